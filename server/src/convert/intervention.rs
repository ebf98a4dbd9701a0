//! Manual changes.

use baudbot_proto::v1;
use baudbot_proto::v1::intervene_request::Intervention as Asked;
use baudbot_sim::{Intervention, Pose};
use tonic::Status;

use crate::message::Request;

/// The request of an operator for a manual change.
pub(crate) fn intervention(asked: Option<Asked>) -> Result<Request, Status> {
    let intervention = match asked {
        None => return Err(Status::invalid_argument("intervention: must be set")),
        Some(Asked::DetachBrain(v1::DetachBrain { robot, restart })) => {
            return Ok(Request::DetachBrain { robot, restart });
        }
        Some(Asked::PlaceRobot(v1::PlaceRobot { robot, x_m, y_m, heading_rad })) => {
            Intervention::PlaceRobot { robot, pose: Pose::new(x_m, y_m, heading_rad) }
        }
        Some(Asked::PlaceThing(v1::PlaceThing { thing, x_m, y_m, heading_rad })) => {
            Intervention::PlaceThing { thing, pose: Pose::new(x_m, y_m, heading_rad) }
        }
        Some(Asked::PullCable(v1::PullCable { robot, pulled })) => Intervention::PullCable { robot, pulled },
        Some(Asked::SetBaud(v1::SetBaud { robot, baud })) => Intervention::SetBaud { robot, baud },
    };
    Ok(Request::Intervene(intervention))
}

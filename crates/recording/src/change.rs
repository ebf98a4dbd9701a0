//! Changes by hand between the contract and the world.

use baudbot_proto::v1;
use baudbot_proto::v1::recorded_change::Change;
use baudbot_sim::model::PortUse;
use baudbot_sim::{Intervention, Pose};

/// A change as it is recorded.
pub fn change(intervention: &Intervention) -> v1::RecordedChange {
    let change = match intervention.clone() {
        Intervention::PlaceRobot { robot, pose } => {
            let [x_m, y_m, heading_rad] = numbers(&pose);
            Change::PlaceRobot(v1::PlaceRobot { robot, x_m, y_m, heading_rad })
        }
        Intervention::PlaceThing { thing, pose } => {
            let [x_m, y_m, heading_rad] = numbers(&pose);
            Change::PlaceThing(v1::PlaceThing { thing, x_m, y_m, heading_rad })
        }
        Intervention::PullCable { robot, pulled } => Change::PullCable(v1::PullCable { robot, pulled }),
        Intervention::SetBaud { robot, baud } => Change::SetBaud(v1::SetBaud { robot, baud }),
        Intervention::OpenPort { robot, port_use } => Change::Port(v1::RecordedPort {
            robot,
            open: port_use != PortUse::Closed,
            simulated_time: port_use == PortUse::Simulated,
        }),
        Intervention::ResetBoard { robot } => Change::ResetBoard(robot),
    };
    v1::RecordedChange { change: Some(change) }
}

/// The change of the world for a change of the contract.
pub fn intervention(change: Change) -> Intervention {
    match change {
        Change::PlaceRobot(v1::PlaceRobot { robot, x_m, y_m, heading_rad }) => {
            Intervention::PlaceRobot { robot, pose: Pose::new(x_m, y_m, heading_rad) }
        }
        Change::PlaceThing(v1::PlaceThing { thing, x_m, y_m, heading_rad }) => {
            Intervention::PlaceThing { thing, pose: Pose::new(x_m, y_m, heading_rad) }
        }
        Change::PullCable(v1::PullCable { robot, pulled }) => Intervention::PullCable { robot, pulled },
        Change::SetBaud(v1::SetBaud { robot, baud }) => Intervention::SetBaud { robot, baud },
        Change::Port(v1::RecordedPort { robot, open, simulated_time }) => {
            let port_use = match (open, simulated_time) {
                (false, _) => PortUse::Closed,
                (true, false) => PortUse::Open,
                (true, true) => PortUse::Simulated,
            };
            Intervention::OpenPort { robot, port_use }
        }
        Change::ResetBoard(robot) => Intervention::ResetBoard { robot },
    }
}

fn numbers(pose: &Pose) -> [f64; 3] {
    [pose.position.x, pose.position.y, pose.heading]
}

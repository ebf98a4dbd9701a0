//! The messages to trainers.

use baudbot_proto::v1;
use baudbot_proto::v1::attach_response::Response;
use baudbot_proto::v1::world_result::Outcome;
use baudbot_sim::{Ending, World};
use bytes::Bytes;
use prost::Message as _;
use tonic::Status;

use super::status::ending_kind;
use super::{battery, score};

/// A world that stands so, in which the trainer's robots can step.
pub(crate) fn turned(turn: Bytes, standing: v1::WorldResult) -> v1::WorldResult {
    let response = v1::AttachResponse::decode(turn).ok().and_then(|response| response.response);
    let outcome = match response {
        Some(Response::Turn(turn)) => Some(Outcome::Turn(turn)),
        // The bytes are this server's own, and are those of a Turn.
        Some(Response::Welcome(_) | Response::Ended(_)) | None => None,
    };
    v1::WorldResult { outcome, ..standing }
}

/// A world that stands so, whose run is over.
pub(crate) fn ended(ending: Option<&Ending>, standing: v1::WorldResult) -> v1::WorldResult {
    let ended = v1::TrainingEnded {
        kind: ending.map(ending_kind).unwrap_or_default().into(),
        ending: ending.map(ToString::to_string).unwrap_or_default(),
    };
    v1::WorldResult { outcome: Some(Outcome::Ended(ended)), ..standing }
}

/// A world in which something was refused.
pub(crate) fn refused(status: &Status) -> v1::WorldResult {
    v1::WorldResult { outcome: Some(Outcome::Refused(problem(status))), ..Default::default() }
}

/// A world of which the trainer holds no robots any more.
pub(crate) fn closed(status: &Status) -> v1::WorldResult {
    v1::WorldResult { outcome: Some(Outcome::Closed(problem(status))), ..Default::default() }
}

fn problem(status: &Status) -> v1::TrainingProblem {
    // Codes of gRPC are not negative.
    v1::TrainingProblem { code: (status.code() as i32).unsigned_abs(), message: status.message().to_owned() }
}

/// A world at the start of a tick with the truth about these robots, but for what the trainer knows of their collisions.
pub(crate) fn standing(world: &World, robots: &[usize]) -> v1::WorldResult {
    v1::WorldResult {
        tick: world.tick(),
        time_ns: world.time().as_ns(),
        truths: robots.iter().map(|&robot| truth(world, robot)).collect(),
        score: score(world),
        ..Default::default()
    }
}

fn truth(world: &World, index: usize) -> v1::Truth {
    let robot = world.robot(index);
    let (motion, counters) = (robot.motion(), robot.counters());
    v1::Truth {
        x_m: motion.pose.position.x,
        y_m: motion.pose.position.y,
        heading_rad: motion.pose.heading,
        speed_m_s: motion.speed_m_s,
        turn_rate_rad_s: motion.turn_rate_rad_s,
        collisions: counters.collisions,
        collided: false,
        distance_m: counters.distance_m,
        battery: battery(&robot),
        in_zone_ns: world.score().in_zone_ns(index).to_vec(),
    }
}

//! What trainers are told.

use baudbot_proto::v1;
use baudbot_proto::v1::attach_response::Response;
use baudbot_proto::v1::world_result::Outcome;
use bytes::Bytes;
use prost::Message as _;
use tonic::Status;

use super::status::ending_kind;
use super::{battery, score};
use crate::truth::{RobotFacts, Truth};

/// A world in which the trainer's robots can step; with how often each of them had collided when it was told last.
pub(crate) fn turned(turn: Bytes, truth: Truth, collisions: &[u64]) -> v1::WorldResult {
    let response = v1::AttachResponse::decode(turn).ok().and_then(|response| response.response);
    let outcome = match response {
        Some(Response::Turn(turn)) => Some(Outcome::Turn(turn)),
        // The bytes are this server's own, and are those of a Turn.
        Some(Response::Welcome(_) | Response::Ended(_)) | None => None,
    };
    v1::WorldResult { outcome, ..stands(truth, collisions) }
}

/// A world whose run is over.
pub(crate) fn ended(truth: Truth, collisions: &[u64]) -> v1::WorldResult {
    let ended = v1::TrainingEnded {
        kind: truth.ending.as_ref().map(ending_kind).unwrap_or_default().into(),
        ending: truth.ending.as_ref().map(ToString::to_string).unwrap_or_default(),
    };
    v1::WorldResult { outcome: Some(Outcome::Ended(ended)), ..stands(truth, collisions) }
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

fn stands(truth: Truth, collisions: &[u64]) -> v1::WorldResult {
    v1::WorldResult {
        tick: truth.tick,
        time_ns: truth.time.as_ns(),
        truths: truth.robots.into_iter().zip(collisions).map(robot).collect(),
        score: truth.score.map(score),
        ..Default::default()
    }
}

fn robot((facts, &collisions): (RobotFacts, &u64)) -> v1::Truth {
    let RobotFacts { motion, .. } = facts;
    v1::Truth {
        x_m: motion.pose.position.x,
        y_m: motion.pose.position.y,
        heading_rad: motion.pose.heading,
        speed_m_s: motion.speed_m_s,
        turn_rate_rad_s: motion.turn_rate_rad_s,
        collisions: facts.collisions,
        collided: facts.collisions > collisions,
        distance_m: facts.distance_m,
        battery: facts.battery.map(battery),
        in_zone_ns: facts.in_zone_ns,
    }
}

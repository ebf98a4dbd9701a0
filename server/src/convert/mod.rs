//! Conversions between the contract's types and the domain's: the only folder that names both.
//!
//! `brain` and `turn` are for brains; `observe`, `detail`, `pins`, `cable` and `coverage` are for observers; `status`, `budget`, `intervention`, `pace` and
//! `replay` are for operators; `trainer` is for trainers. This file has what they share.

mod brain;
mod budget;
mod cable;
mod coverage;
mod detail;
mod intervention;
mod observe;
mod pace;
mod pins;
mod replay;
mod status;
mod trainer;
mod turn;

use baudbot_proto::v1;

use crate::frame::{Charge, Score, ZoneScore};

pub(crate) use brain::{AttachResponse, delivery, first_response, welcome, write, writes};
pub(crate) use budget::robot_budget;
pub(crate) use cable::cable_news;
pub(crate) use coverage::coverage;
pub(crate) use intervention::intervention;
pub(crate) use observe::{frame, own_in_bytes, truth_in_bytes, world_description};
pub use pace::pace_of;
pub(crate) use pace::{pace_from, pace_to};
pub(crate) use replay::replay;
pub(crate) use status::{recording_status, status, thinking};
pub(crate) use trainer::{closed, ended, refused, turned};
pub(crate) use turn::{RobotTurn, turn};

fn battery(Charge { share, voltage_v, state }: Charge) -> v1::BatteryStatus {
    v1::BatteryStatus {
        charge: share,
        voltage_v,
        current_a: state.current_a,
        used_j: state.used_j,
        charged_j: state.charged_j,
    }
}

fn score(Score { covered, sensed, zones }: Score) -> v1::Score {
    let goals = || zones.iter().filter(|zone| zone.is_goal);
    v1::Score {
        covered,
        sensed,
        goals_reached: goals().filter(|zone| zone.visited).count() as u32,
        goals: goals().count() as u32,
        zones: zones
            .into_iter()
            .map(|ZoneScore { name, is_goal, visited }| v1::ZoneStatus { zone: name, goal: is_goal, visited })
            .collect(),
    }
}

//! Conversions between the contract's types and the world's. Observers' details, reports of recordings and of replays are made where
//! their numbers are, with these conversions for all that is more than a number.
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
use baudbot_sim::surroundings::Zone;
use baudbot_sim::{RobotView, World};

pub(crate) use brain::{AttachResponse, delivery, first_response, welcome, write, writes};
pub(crate) use budget::robot_budget;
pub(crate) use cable::cable_item;
pub(crate) use coverage::coverage;
pub(crate) use detail::{ray_fan, timeline_event};
pub(crate) use intervention::intervention;
pub(crate) use observe::{truth, world_description};
pub use pace::pace_of;
pub(crate) use pace::{pace_from, pace_to};
pub(crate) use pins::event as pin_event;
pub(crate) use replay::replay;
pub use status::world_status;
pub(crate) use status::{activity, cycle_status, line_status, nanos, pace_status, status, thinking};
pub(crate) use trainer::{closed, ended, refused, standing, turned};
pub(crate) use turn::{RobotTurn, turn};

/// The charge of a robot's battery; `None` if the robot has none.
fn battery(robot: &RobotView<'_>) -> Option<v1::BatteryStatus> {
    let (battery, state) = robot.battery()?;
    Some(v1::BatteryStatus {
        charge: state.share(battery),
        voltage_v: state.terminal_v(battery),
        current_a: state.current_a,
        used_j: state.used_j,
        charged_j: state.charged_j,
    })
}

/// The referee's counts; `None` if there is nothing to count.
fn score(world: &World) -> Option<v1::Score> {
    let (scenario, score) = (world.scenario(), world.score());
    let (covered, sensed) = (score.covered(&scenario.rules), score.sensed(&scenario.rules));
    let status = |(zone, &visited): (&Zone, &bool)| v1::ZoneStatus {
        zone: zone.name.clone(),
        goal: zone.goal,
        visited,
    };
    let zones: Vec<_> = scenario.surroundings.zones.iter().zip(score.visited()).map(status).collect();
    let goals = || zones.iter().filter(|zone| zone.goal);
    let (goals_reached, goals) = (goals().filter(|zone| zone.visited).count(), goals().count());
    let something = covered.is_some() || sensed.is_some() || !zones.is_empty();
    something.then_some(v1::Score {
        covered,
        sensed,
        goals_reached: goals_reached as u32,
        goals: goals as u32,
        zones,
    })
}

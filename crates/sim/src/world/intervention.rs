//! Manual changes: an operator moves a robot, pulls a cable, or sets another baud rate.
//!
//! They happen between two ticks, and are inputs like a brain's bytes: the same ones at the same ticks make the same
//! run. A cable that is changed is another cable in the scenario from then on; [`World::hash`](crate::World::hash)
//! covers that.

use alloc::string::{String, ToString};
use alloc::sync::Arc;
use alloc::vec::Vec;

use baudbot_geometry::{Pose, Vector, angle};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::World;
use crate::link::{Link, Uart};
use crate::model::PortUse;
use crate::movable::{Body, MovableState};
use crate::time::SimTime;

/// A change by hand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Intervention {
    /// A robot is put somewhere else, where it stands still. Its wheels do not turn meanwhile.
    PlaceRobot {
        /// The robot's name.
        robot: String,
        /// World from robot.
        pose: Pose,
    },
    /// Something that is pushed is put somewhere else, where it lies still.
    PlaceThing {
        /// The thing's name.
        thing: String,
        /// World from thing.
        pose: Pose,
    },
    /// The cable between a robot and its brain is pulled, or plugged in again. What would arrive meanwhile is lost.
    PullCable {
        /// The robot's name.
        robot: String,
        /// Whether the cable is pulled; otherwise it is plugged in.
        pulled: bool,
    },
    /// Both ends of the cable between a robot and its brain change to another baud rate. What is on the wire by then
    /// arrives as it would have.
    SetBaud {
        /// The robot's name.
        robot: String,
        /// The rate, in bits a second.
        baud: u32,
    },
    /// The laptop's serial ports at a robot's cables are opened for a program, or closed again.
    OpenPort {
        /// The robot's name.
        robot: String,
        /// Who reads them from now on.
        port_use: PortUse,
    },
    /// The microcontroller of a robot is reset, as many boards are by DTR when a program opens their port. Its bootloader
    /// waits, motors get no signal, and what was on its way to it is lost. Its schedules keep their grid in time.
    ResetBoard {
        /// The robot's name.
        robot: String,
    },
}

/// A reason why a change was not made. Nothing has changed then.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum InterventionError {
    /// The tick has begun; changes are made before that.
    #[error("the world is within a tick")]
    WithinTick,
    /// The run is over.
    #[error("the run has ended")]
    Ended,
    /// No such robot or thing.
    #[error("{field}: there is no {kind} `{name}`")]
    Unknown {
        /// The field that names it.
        field: &'static str,
        /// The kind that it was to be.
        kind: &'static str,
        /// The name, cut off if it is long.
        name: String,
    },
    /// The number is not a place.
    #[error("{field}: must be a number from -{most} to {most}")]
    Place {
        /// The field of the place.
        field: &'static str,
        /// The greatest that it can be.
        most: u32,
    },
    /// The place is taken.
    #[error("no room: `{with}` is in the way")]
    NoRoom {
        /// The obstacle.
        with: String,
    },
    /// The robot has no such cable.
    #[error("robot: `{robot}` has no {cable}")]
    NoCable {
        /// The robot's name.
        robot: String,
        /// The cable that was asked for.
        cable: &'static str,
    },
    /// The rate is none that the cable can have.
    #[error("baud: must be {least} to {most} here, is {baud}")]
    Baud {
        /// The rate.
        baud: u32,
        /// The least that it can be.
        least: u64,
        /// The most that it can be.
        most: u64,
    },
    /// The change has been made too often.
    #[error(
        "robot: the cable of `{robot}` cannot be changed: cables have been changed {MOST_ALTERED} times, the limit; reset the world"
    )]
    TooOften {
        /// The robot's name.
        robot: String,
    },
}

/// The thing that is put somewhere else.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Placed {
    Robot(usize),
    Thing(usize),
}

type Result<T> = core::result::Result<T, InterventionError>;

/// The changes of the scenario. They are no part of the state of a world without manual changes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Altered(Vec<(SimTime, Intervention)>);

impl Altered {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Keeps a change. Programs open ports and reset boards as often as they like, and only the last time matters: it takes the place of
    /// the one before. A port that is closed again is as it was.
    pub(super) fn note(&mut self, at: SimTime, change: &Intervention) {
        self.0.retain(|(_, earlier)| !is_outdone(earlier, change));
        if !matches!(change, Intervention::OpenPort { port_use: PortUse::Closed, .. }) {
            self.0.push((at, change.clone()));
        }
    }

    /// Whether the board of this robot has been reset.
    fn has_reset(&self, name: &str) -> bool {
        self.0.iter().any(|(_, change)| matches!(change, Intervention::ResetBoard { robot } if robot == name))
    }
}

/// Whether nothing is left of a change after this one.
fn is_outdone(earlier: &Intervention, later: &Intervention) -> bool {
    match (earlier, later) {
        (Intervention::OpenPort { robot: a, .. }, Intervention::OpenPort { robot: b, .. })
        | (Intervention::ResetBoard { robot: a }, Intervention::ResetBoard { robot: b }) => a == b,
        _ => false,
    }
}

impl World {
    /// Changes something by hand, between two ticks.
    ///
    /// # Errors
    /// An error with the reason; then nothing has changed.
    pub fn intervene(&mut self, intervention: &Intervention) -> Result<()> {
        if self.ending().is_some() {
            return Err(InterventionError::Ended);
        }
        if self.is_begun() {
            return Err(InterventionError::WithinTick);
        }
        let changed = match intervention {
            Intervention::PlaceRobot { robot, pose } => return self.place_robot(robot, pose),
            Intervention::PlaceThing { thing, pose } => return self.place_thing(thing, pose),
            Intervention::PullCable { robot, pulled } => self.pull_cable(robot, *pulled)?,
            Intervention::SetBaud { robot, baud } => self.set_baud(robot, *baud)?,
            Intervention::OpenPort { robot, port_use } => {
                self.open_port(robot, *port_use)?.is_some_and(|own| self.hand_over_ports(own, *port_use))
            }
            Intervention::ResetBoard { robot } => self.reset_board(robot)?,
        };
        if changed {
            self.altered.note(self.time(), intervention);
        }
        Ok(())
    }

    fn place_robot(&mut self, name: &str, pose: &Pose) -> Result<()> {
        let own = self.robot_named(name)?;
        let pose = checked(pose)?;
        let spec = self.scenario().robots[own].clone();
        self.has_room(&spec.form().at(&pose), Placed::Robot(own))?;
        self.state_mut().robots[own].put_down(&spec, pose);
        Ok(())
    }

    fn place_thing(&mut self, name: &str, pose: &Pose) -> Result<()> {
        let things = &self.scenario().movables;
        let found = things.iter().position(|thing| thing.name == name);
        let i = found.ok_or_else(|| unknown("thing", "thing that is pushed", name))?;
        let pose = checked(pose)?;
        self.has_room(&things[i].shape.form().at(&pose), Placed::Thing(i))?;
        self.state_mut().movables[i] = MovableState { pose, velocity_m_s: Vector::zeros(), spin_rad_s: 0.0 };
        Ok(())
    }

    /// Whether nothing else is where this body is to be.
    fn has_room(&self, body: &Body, own: Placed) -> Result<()> {
        let no_room = |with: &str| Err(InterventionError::NoRoom { with: with.to_string() });
        let scenario = self.scenario();
        if let Some(thing) = body.arena_thing(&scenario.arena) {
            return no_room(scenario.arena.name_of(thing));
        }
        let state = self.state();
        let robots = scenario.robots.iter().zip(&state.robots).enumerate();
        let robots = robots.filter(|(i, _)| own != Placed::Robot(*i));
        let robots = robots.map(|(_, (spec, robot))| (&spec.name, spec.form().at(&robot.motion.pose)));
        let movers = scenario.movers.iter().zip(&state.movers);
        let movers = movers.map(|(mover, state)| (&mover.name, mover.form().at(&state.pose)));
        let movables = scenario.movables.iter().zip(&state.movables).enumerate();
        let movables = movables.filter(|(i, _)| own != Placed::Thing(*i));
        let movables = movables.map(|(_, (thing, state))| (&thing.name, thing.shape.form().at(&state.pose)));
        match robots.chain(movers).chain(movables).find(|(_, other)| other.overlaps(body)) {
            Some((with, _)) => no_room(with),
            None => Ok(()),
        }
    }

    /// Returns whether that made a difference.
    fn pull_cable(&mut self, name: &str, pulled: bool) -> Result<bool> {
        let Some(own) = self.cut_cable(name, self.time(), pulled)? else { return Ok(false) };
        let (seed, link) = (self.scenario().seed, self.scenario().robots[own].link.clone());
        self.state_mut().robots[own].watch_outages(&link, seed, name);
        Ok(true)
    }

    /// Changes the cable of the robot of this name; returns which robot that is, if it makes a difference.
    fn cut_cable(&mut self, name: &str, at: SimTime, pulled: bool) -> Result<Option<usize>> {
        let own = self.robot_named(name)?;
        let link = &self.scenario().robots[own].link;
        if let Link::Ideal | Link::Onboard = link {
            return Err(InterventionError::NoCable { robot: name.to_string(), cable: "cable" });
        }
        if link.is_pulled() == pulled {
            return Ok(None);
        }
        self.may_alter(name)?;
        let link = &mut Arc::make_mut(&mut self.scenario_mut().robots[own].model).link;
        link.pull(at, pulled);
        Ok(Some(own))
    }

    /// Returns whether that made a difference.
    pub(super) fn set_baud(&mut self, name: &str, baud: u32) -> Result<bool> {
        let Some(own) = self.change_baud(name, baud)? else { return Ok(false) };
        let model = Arc::clone(&self.scenario().robots[own].model);
        self.state_mut().robots[own].begin_bursts(&model.link);
        Ok(true)
    }

    /// Changes the baud rate, with the result of [`cut_cable`](Self::cut_cable).
    fn change_baud(&mut self, name: &str, baud: u32) -> Result<Option<usize>> {
        let own = self.robot_named(name)?;
        let spec = &self.scenario().robots[own];
        let Link::Uart(uart) = &spec.link else {
            return Err(InterventionError::NoCable { robot: name.to_string(), cable: "serial cable" });
        };
        let (least, most) = (spec.firmware.least_baud(uart), uart.most_baud());
        if !(least..=most).contains(&u64::from(baud)) {
            return Err(InterventionError::Baud { baud, least, most });
        }
        if uart.baud == baud {
            return Ok(None);
        }
        self.may_alter(name)?;
        let changed = Uart { baud, ..uart.clone() };
        let spec = &mut self.scenario_mut().robots[own];
        Arc::make_mut(&mut spec.model).link = Link::Uart(changed);
        Ok(Some(own))
    }

    /// Opens or closes the port, with the result of [`cut_cable`](Self::cut_cable).
    fn open_port(&mut self, name: &str, port_use: PortUse) -> Result<Option<usize>> {
        let own = self.robot_named(name)?;
        let spec = &self.scenario().robots[own];
        if let Link::Onboard = spec.link {
            return Err(InterventionError::NoCable { robot: name.to_string(), cable: "cable" });
        }
        if spec.port_use == port_use {
            return Ok(None);
        }
        if port_use != PortUse::Closed {
            self.may_alter(name)?;
        }
        self.scenario_mut().robots[own].port_use = port_use;
        Ok(Some(own))
    }

    /// The ports of this robot are a program's from now on, or no longer. Always true.
    fn hand_over_ports(&mut self, own: usize, port_use: PortUse) -> bool {
        let (spec, now) = (self.scenario().robots[own].clone(), self.time());
        self.state_mut().robots[own].open_ports(&spec, port_use != PortUse::Closed, now);
        true
    }

    /// Returns whether that made a difference, which it always does.
    fn reset_board(&mut self, name: &str) -> Result<bool> {
        let now = self.time();
        let own = self.start_board(name, now)?;
        let spec = self.scenario().robots[own].clone();
        self.state_mut().robots[own].reset_board(&spec, now);
        Ok(true)
    }

    /// The bootloader of a robot waits from `at` on.
    fn start_board(&mut self, name: &str, at: SimTime) -> Result<usize> {
        let own = self.robot_named(name)?;
        if let Link::Onboard = self.scenario().robots[own].link {
            return Err(InterventionError::NoCable { robot: name.to_string(), cable: "cable" });
        }
        if !self.altered.has_reset(name) {
            self.may_alter(name)?;
        }
        let waits_ns = self.origin().robots[own].processor.bootloader_ns;
        let model = Arc::make_mut(&mut self.scenario_mut().robots[own].model);
        model.processor.bootloader_ns = at.as_ns() + waits_ns;
        Ok(own)
    }

    /// The cables as they have been changed before this state was kept; `false` if they cannot have been.
    pub(crate) fn alter_again(&mut self, altered: Altered) -> bool {
        let mut before = SimTime::ZERO;
        for (at, intervention) in &altered.0 {
            let changed = match intervention {
                Intervention::PullCable { robot, pulled } => self.cut_cable(robot, *at, *pulled),
                Intervention::SetBaud { robot, baud } => self.change_baud(robot, *baud),
                Intervention::OpenPort { robot, port_use } => self.open_port(robot, *port_use),
                Intervention::ResetBoard { robot } => self.start_board(robot, *at).map(Some),
                Intervention::PlaceRobot { .. } | Intervention::PlaceThing { .. } => Ok(None),
            };
            if !matches!(changed, Ok(Some(_))) || *at < before {
                return false;
            }
            before = *at;
        }
        self.altered = altered;
        before <= self.time() && self.altered.0.len() <= MOST_ALTERED
    }

    /// The list of changes is kept with every snapshot, so it has an end.
    fn may_alter(&self, name: &str) -> Result<()> {
        let is_full = self.altered.0.len() >= MOST_ALTERED;
        if is_full { Err(InterventionError::TooOften { robot: name.to_string() }) } else { Ok(()) }
    }

    fn robot_named(&self, name: &str) -> Result<usize> {
        let found = self.scenario().robots.iter().position(|spec| spec.name == name);
        found.ok_or_else(|| unknown("robot", "robot", name))
    }
}

fn unknown(field: &'static str, kind: &'static str, name: &str) -> InterventionError {
    InterventionError::Unknown { field, kind, name: name.chars().take(80).collect() }
}

fn checked(pose: &Pose) -> Result<Pose> {
    let place = |field, value: f64, most: u32| {
        let is_in = value.abs() <= f64::from(most);
        if is_in { Ok(value) } else { Err(InterventionError::Place { field, most }) }
    };
    let x = place("x_m", pose.position.x, MOST_M)?;
    let y = place("y_m", pose.position.y, MOST_M)?;
    Ok(Pose::new(x, y, angle::wrap(place("heading_rad", pose.heading, MOST_RAD)?)))
}

const MOST_M: u32 = 1_000_000;
const MOST_RAD: u32 = 10;

/// Most times that cables are changed in a run.
const MOST_ALTERED: usize = 10_000;

//! The quantities of a run that requirements are about. They are the truth, which no brain sees.

use baudbot_run::UnknownName;
use baudbot_sim::{Ending, RobotView, World};

/// A quantity of a robot or of the world at an instant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Observable {
    /// One that needs no more than its name.
    Plain(Plain),
    /// The age of the last reading of this sensor that has come to the brain, in milliseconds; infinite before there is one.
    AgeMs(String),
}

/// A quantity that needs no more than its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "`PLAIN` says what each is")]
pub enum Plain {
    ClearanceM,
    SpeedMS,
    TurnRateRadS,
    XM,
    YM,
    HeadingRad,
    LeftSignal,
    RightSignal,
    DistanceM,
    Collisions,
    Battery,
    DeadlineSlackMs,
    GoalsReached,
    Covered,
    TimeS,
}

/// The names of all plain quantities, with their meanings.
pub const PLAIN: [(Plain, &str, &str); 15] = [
    (
        Plain::ClearanceM,
        "clearance_m",
        "distance of the body from anything it could run into; 0 at a collision",
    ),
    (Plain::SpeedMS, "speed_m_s", "forward speed; negative backwards"),
    (Plain::TurnRateRadS, "turn_rate_rad_s", "turn rate; positive to the left"),
    (Plain::XM, "x_m", "position along x"),
    (Plain::YM, "y_m", "position along y"),
    (Plain::HeadingRad, "heading_rad", "heading, from −π to π"),
    (Plain::LeftSignal, "left_signal", "signal of the left motor, from −1 to 1"),
    (Plain::RightSignal, "right_signal", "signal of the right motor, from −1 to 1"),
    (Plain::DistanceM, "distance_m", "distance driven so far"),
    (Plain::Collisions, "collisions", "collisions so far"),
    (Plain::Battery, "battery", "charge, as a fraction of the capacity; 1 without a battery"),
    (
        Plain::DeadlineSlackMs,
        "deadline_slack_ms",
        "deadline less the longest answered control cycle so far; the deadline before there is one",
    ),
    (Plain::GoalsReached, "goals_reached", "zones with `goal` that were reached so far"),
    (
        Plain::Covered,
        "covered",
        "fraction of the free floor that bodies covered so far; 0 if it is not measured",
    ),
    (Plain::TimeS, "time_s", "simulated time"),
];

/// The name of the quantity that takes a sensor.
pub const AGE: &str = "age_ms";

/// A name in a requirement that stands for nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// There is no such quantity.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    /// An age needs to know of what.
    #[error("`{AGE}` takes the name of a sensor: {AGE}(ir_front)")]
    NoSensor,
    /// Nothing else takes anything.
    #[error("`{0}` takes nothing in parentheses")]
    NoFunction(&'static str),
}

impl Observable {
    /// The quantity of this name, with what stands in parentheses behind it.
    ///
    /// # Errors
    /// If there is none, with the nearest.
    pub fn named(name: &str, argument: Option<&str>) -> Result<Self, NameError> {
        if name == AGE {
            return argument.map(|sensor| Self::AgeMs(sensor.to_owned())).ok_or(NameError::NoSensor);
        }
        let found = PLAIN.iter().find(|(_, known, _)| *known == name);
        let names = || PLAIN.iter().map(|(_, known, _)| *known).chain([AGE]).collect::<Vec<_>>();
        let (plain, known, _) = found.ok_or_else(|| UnknownName::new("quantity", name, &names()))?;
        if argument.is_some() { Err(NameError::NoFunction(known)) } else { Ok(Self::Plain(*plain)) }
    }

    /// The value of a robot in the tick that is begun.
    ///
    /// # Errors
    /// If the robot has no such sensor.
    pub(crate) fn value(&self, world: &World, robot: usize) -> Result<f64, UnknownName> {
        match self {
            Self::Plain(plain) => Ok(plain.value(world, robot)),
            Self::AgeMs(sensor) => age_ms(world, &world.robot(robot), sensor),
        }
    }
}

impl std::fmt::Display for Observable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Plain(plain) => f.write_str(PLAIN[*plain as usize].1),
            Self::AgeMs(sensor) => write!(f, "{AGE}({sensor})"),
        }
    }
}

impl Plain {
    fn value(self, world: &World, robot: usize) -> f64 {
        let view = world.robot(robot);
        let motion = view.motion();
        match self {
            Self::ClearanceM => world.clearance_m(robot),
            Self::SpeedMS => motion.speed_m_s,
            Self::TurnRateRadS => motion.turn_rate_rad_s,
            Self::XM => motion.pose.position.x,
            Self::YM => motion.pose.position.y,
            Self::HeadingRad => baudbot_geometry::angle::difference(motion.pose.heading, 0.0),
            Self::LeftSignal => view.signals().left,
            Self::RightSignal => view.signals().right,
            Self::DistanceM => view.counters().distance_m,
            Self::Collisions => view.counters().collisions as f64,
            Self::Battery => view.battery().map_or(1.0, |(battery, state)| state.share(battery)),
            Self::DeadlineSlackMs => {
                let excess_ns =
                    excess_ns(&view).map_or(-(view.spec().deadline.within_ns as f64), |ns| ns as f64);
                -excess_ns / 1e6
            }
            Self::GoalsReached => {
                let zones = world.scenario().surroundings.zones.iter().zip(world.score().visited());
                let zones = zones.filter(|(zone, visited)| zone.goal && **visited).count() as f64;
                // The one goal of a scenario that has no zones for goals is in no score.
                zones + f64::from(u8::from(matches!(world.ending(), Some(Ending::GoalReached(_)))))
            }
            Self::Covered => world.score().covered(&world.scenario().rules).unwrap_or(0.0),
            Self::TimeS => world.time().as_seconds(),
        }
    }
}

fn age_ms(world: &World, view: &RobotView<'_>, name: &str) -> Result<f64, UnknownName> {
    let sensors = &view.spec().sensors;
    let place = sensors.iter().position(|sensor| sensor.name == name);
    let names = || sensors.iter().map(|sensor| sensor.name.as_str()).collect::<Vec<_>>();
    let place = place.ok_or_else(|| UnknownName::new("sensor", name, &names()))?;
    let sampled_at = view.heard(place).sampled_at;
    Ok(sampled_at.map_or(f64::INFINITY, |at| world.time().since(at) as f64 / 1e6))
}

/// The time by which the longest answered cycle of a robot exceeds its deadline; negative if it keeps it.
pub(crate) fn excess_ns(robot: &RobotView<'_>) -> Option<i64> {
    let longest_ns = robot.cycles().durations.max_ns()?;
    Some(longest_ns.cast_signed() - robot.spec().deadline.within_ns.cast_signed())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_stands_in_its_place_and_in_the_book() {
        let book = include_str!("../../../../docs/reference/experiments.md");
        for (i, (plain, name, _)) in PLAIN.iter().enumerate() {
            assert_eq!(*plain as usize, i, "{name}");
            assert_eq!(Observable::named(name, None), Ok(Observable::Plain(*plain)));
            assert_eq!(Observable::Plain(*plain).to_string(), *name);
            assert!(book.contains(&format!("\n| `{name}` | ")), "{name}");
        }
        assert!(book.contains("\n| `age_ms(SENSOR)` | "));
    }

    #[test]
    fn a_wrong_name_is_told_with_the_nearest() {
        let error = |name, argument| Observable::named(name, argument).unwrap_err().to_string();
        assert!(error("clearence_m", None).contains("did you mean `clearance_m`?"));
        assert_eq!(error("age_ms", None), "`age_ms` takes the name of a sensor: age_ms(ir_front)");
        assert_eq!(error("speed_m_s", Some("a")), "`speed_m_s` takes nothing in parentheses");
        assert_eq!(Observable::named("age_ms", Some("ir")).unwrap().to_string(), "age_ms(ir)");
    }
}

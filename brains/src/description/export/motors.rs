//! The motor behaviours that have a counterpart in C.

use std::fmt::Display;

use baudbot_brain::Signals;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::super::DescriptionError;
use super::super::raw::RawProcess;
use super::Robot;
use super::fragment::Fragment;
use super::writer::{Writer, c, plain};
use crate::avoid::{self, Avoid};
use crate::behavior::fixed_action::{self, FixedAction};
use crate::behavior::follow_wall::{self, FollowWall, Side};
use crate::behavior::taxis::{self, Taxis};
use crate::behavior::turn_away::{self, TurnAway};
use crate::chance::Chance;
use crate::parameter::{Parameter, ParameterError};
use crate::throttle::within;
use crate::{constant, wander};

/// The writer of a behaviour's function.
type Write = fn(&Exported<'_>, &mut Writer, &Robot<'_>) -> Result<Activation, ParameterError>;

/// The kinds that are exported.
const KINDS: [(&str, Write); 7] = [
    ("avoid", |motor, writer, robot| motor.avoid(writer, robot)),
    ("constant", |motor, writer, robot| motor.constant(writer, robot)),
    ("fixed_action", |motor, writer, _| motor.fixed_action(writer)),
    ("follow_wall", |motor, writer, robot| motor.follow_wall(writer, robot)),
    ("taxis", |motor, writer, robot| motor.taxis(writer, robot)),
    ("turn_away", |motor, writer, robot| motor.turn_away(writer, robot)),
    ("wander", |motor, writer, robot| motor.wander(writer, robot)),
];

/// The names of the kinds that are exported.
pub(super) fn kinds() -> [&'static str; KINDS.len()] {
    KINDS.map(|(kind, _)| kind)
}

/// The statements when a behaviour is entered, and when it is left.
#[derive(Default)]
pub(super) struct Activation {
    pub(super) enter: String,
    pub(super) leave: String,
}

/// A behaviour of the description.
pub(super) struct Exported<'a> {
    pub(super) place: usize,
    pub(super) name: &'a str,
    pub(super) process: &'a RawProcess,
}

impl Exported<'_> {
    /// The writer of this kind, or the error if it is not exported.
    fn writer(&self) -> Result<Write, DescriptionError> {
        let kind = self.process.kind.as_str();
        let known = KINDS.iter().find(|(known, _)| *known == kind);
        known.map(|(_, write)| *write).ok_or_else(|| {
            let problem = format!("`{kind}` cannot be exported; these can: {}", kinds().join(", "));
            DescriptionError::new(format!("motor.{}.kind", self.name), problem)
        })
    }

    /// Whether this kind is exported.
    pub(super) fn check(&self) -> Result<(), DescriptionError> {
        self.writer().map(drop)
    }

    /// The function `brain_motor_PLACE`.
    pub(super) fn write(
        &self,
        writer: &mut Writer,
        robot: &Robot<'_>,
    ) -> Result<Activation, DescriptionError> {
        let written = self.writer()?(self, writer, robot);
        let path = || format!("motor.{}.parameters", self.name);
        written.map_err(|problem| DescriptionError::new(path(), problem.to_string()))
    }

    fn read<P: DeserializeOwned>(&self) -> Result<P, ParameterError> {
        Ok(baudbot_fields::read(self.process.parameters.clone())?)
    }

    /// The function of the behaviour's step, which leaves the signals as they are if it says nothing.
    fn step(&self, writer: &mut Writer, body: impl FnOnce(&mut Writer)) {
        let place = self.place;
        let signature = format!(
            "void brain_motor_{place}(struct brain *brain, const struct brain_readings *readings, brain_real *signals)"
        );
        writer.function(format_args!("{}.", plain(self.name)), signature, |writer| {
            writer.line("(void)brain;");
            writer.line("(void)readings;");
            body(writer);
        });
    }

    fn constant(&self, writer: &mut Writer, robot: &Robot<'_>) -> Result<Activation, ParameterError> {
        let constant::Parameters { left, right } = set(constant::PARAMETERS, &self.process.parameters);
        let Signals { left, right } = within(robot.body.signal_limit, Signals { left, right });
        self.step(writer, |writer| signals(writer, c(left), c(right)));
        Ok(Activation::default())
    }

    fn wander(&self, writer: &mut Writer, robot: &Robot<'_>) -> Result<Activation, ParameterError> {
        let place = self.place;
        let p: wander::Parameters = set(wander::PARAMETERS, &self.process.parameters);
        writer.uses(Fragment::Wander);
        writer.field(format_args!("struct brain_wander wander_{place}"), plain(self.name));
        self.chance(writer, robot, &format!("wander_{place}.chance"));
        let way = |left, right| {
            let Signals { left, right } = within(robot.body.signal_limit, Signals { left, right });
            format!("{{{}, {}}}", c(left), c(right))
        };
        let ways = [way(p.forward, p.forward), way(p.turn, -p.turn), way(-p.turn, p.turn)].join(", ");
        let [turn, stop, left] =
            [p.turn_probability, p.stop_turn_probability, p.left_turn_probability].map(c);
        writer.line(format_args!(
            "static const struct brain_wandering brain_wandering_{place} = {{{{{ways}}}, {turn}, {stop}, {left}}};"
        ));
        self.step(writer, |writer| {
            writer.line(format_args!(
                "brain_wander(&brain->wander_{place}, &brain_wandering_{place}, signals);"
            ));
        });
        Ok(Activation::default())
    }

    fn avoid(&self, writer: &mut Writer, robot: &Robot<'_>) -> Result<Activation, ParameterError> {
        let (place, body) = (self.place, robot.body);
        let p: avoid::Parameters = set(avoid::PARAMETERS, &self.process.parameters);
        let avoid = Avoid::new(p, Chance::new(robot.seed, ""), body);
        let eyes = avoid.map(|avoid| avoid.eyes).unwrap_or_default();
        let count = eyes.len();
        writer.uses(Fragment::Avoid);
        writer.field(format_args!("struct brain_avoid avoid_{place}"), plain(self.name));
        writer.field(format_args!("struct brain_eye eyes_{place}[{count}]"), plain(self.name));
        self.chance(writer, robot, &format!("avoid_{place}.chance"));
        let look = |eye: &avoid::Eye| {
            let side = if eye.bearing_rad > 0.0 {
                "1"
            } else if eye.bearing_rad < 0.0 {
                "-1"
            } else {
                "0"
            };
            format!("{{{}, {}, {side}}}", eye.sensor, robot.value(eye.sensor))
        };
        let looks = eyes.iter().map(look).collect::<Vec<_>>().join(", ");
        let caution = caution(&p);
        writer.line(format_args!("static const struct brain_look brain_looks_{place}[] = {{{looks}}};"));
        writer.line(format_args!("static const struct brain_caution brain_caution_{place} = {{{caution}}};"));
        self.step(writer, |writer| {
            let (state, eyes) = (format!("&brain->avoid_{place}"), format!("brain->eyes_{place}"));
            writer.line(format_args!("brain_avoid({state}, &brain_caution_{place}, {eyes}, brain_looks_{place}, {count}, readings, signals);"));
        });
        Ok(Activation::default())
    }

    fn fixed_action(&self, writer: &mut Writer) -> Result<Activation, ParameterError> {
        let place = self.place;
        let action = FixedAction::new(self.read::<fixed_action::Parameters>()?)?;
        writer.uses(Fragment::Since);
        writer.field(format_args!("uint64_t since_ns_{place}"), "when the fixed action was released");
        writer.field(format_args!("uint8_t runs_{place}"), "whether it runs");
        self.step(writer, |writer| {
            writer.line("brain_real left_s;");
            writer.line(format_args!("if (!brain->runs_{place}) return;"));
            writer.line(format_args!("left_s = brain_since(brain->since_ns_{place}, readings->at_ns);"));
            for [left, right, seconds] in &action.motions {
                writer.block(format_args!("if (left_s < {})", c(*seconds)), |writer| {
                    signals(writer, c(*left), c(*right));
                    writer.line("return;");
                });
                writer.line(format_args!("left_s -= {};", c(*seconds)));
            }
            writer.line(format_args!("brain->runs_{place} = 0;"));
            signals(writer, 0, 0);
        });
        let enter = format!("{{ brain->since_ns_{place} = readings->at_ns; brain->runs_{place} = 1; }}");
        Ok(Activation { enter, leave: format!("brain->runs_{place} = 0;") })
    }

    fn turn_away(&self, writer: &mut Writer, robot: &Robot<'_>) -> Result<Activation, ParameterError> {
        let place = self.place;
        let away = TurnAway::new(self.read::<turn_away::Parameters>()?, robot.body)?;
        writer.uses(Fragment::Max);
        writer.field(format_args!("uint8_t leftwards_{place}"), "whether it turns to the left");
        let signature =
            format!("void brain_enter_{place}(struct brain *brain, const struct brain_readings *readings)");
        writer.function("The way of turning is chosen.", signature, |writer| {
            writer.line("brain_real left = -INFINITY, right = -INFINITY;");
            for eye in &away.eyes {
                let side = if eye.is_left { "left" } else { "right" };
                let sign = if eye.is_distance { "-" } else { "" };
                let (heard, value) = (robot.has_heard(eye.sensor), robot.reading(eye.sensor));
                writer.line(format_args!("if ({heard}) {side} = brain_max({side}, {sign}{value});"));
            }
            writer.line(format_args!("brain->leftwards_{place} = right >= left;"));
        });
        self.step(writer, |writer| {
            let [left, right] = [away.turn, -away.turn].map(c);
            writer.line(format_args!("signals[1] = brain->leftwards_{place} ? {left} : {right};"));
            writer.line("signals[0] = -signals[1];");
        });
        Ok(Activation { enter: format!("brain_enter_{place}(brain, readings);"), leave: String::new() })
    }

    fn follow_wall(&self, writer: &mut Writer, robot: &Robot<'_>) -> Result<Activation, ParameterError> {
        let wall = FollowWall::new(self.read::<follow_wall::Parameters>()?, robot.body)?;
        let p = &wall.parameters;
        writer.uses(Fragment::Clamp);
        self.step(writer, |writer| {
            writer.line("brain_real far, leftwards;");
            stand_unless(writer, &robot.has_heard(wall.sensor));
            let (reading, wanted) = (robot.reading(wall.sensor), c(p.reading));
            let far = if wall.is_distance {
                format!("{reading} - {wanted}")
            } else {
                format!("{wanted} - {reading}")
            };
            writer.line(format_args!("far = {far};"));
            let sign = if p.side == Side::Left { "" } else { "-" };
            let [gain, least, most] = [p.gain, -p.limit, p.limit].map(c);
            writer.line(format_args!("leftwards = {sign}(brain_clamp({gain} * far, {least}, {most}) / 2);"));
            bend(writer, p.forward);
        });
        Ok(Activation::default())
    }

    fn taxis(&self, writer: &mut Writer, robot: &Robot<'_>) -> Result<Activation, ParameterError> {
        let taxis = Taxis::new(&self.read::<taxis::Parameters>()?, robot.body)?;
        self.step(writer, |writer| {
            writer.line("brain_real left, right, sum, leftwards;");
            let [left, right] = taxis.sensors;
            let heard = taxis.sensors.map(|sensor| robot.has_heard(sensor)).join(" && ");
            stand_unless(writer, &heard);
            writer.line(format_args!("left = {};", robot.reading(left)));
            writer.line(format_args!("right = {};", robot.reading(right)));
            writer.line("sum = (left < 0 ? -left : left) + (right < 0 ? -right : right);");
            let gain = c(taxis.gain);
            writer.line(format_args!("leftwards = {gain} * (sum > 0 ? (left - right) / sum : 0) / 2;"));
            bend(writer, taxis.forward);
        });
        Ok(Activation::default())
    }

    /// The stream of random numbers of this kind on this robot.
    fn chance(&self, writer: &mut Writer, robot: &Robot<'_>, field: &str) {
        let name = format!("{}/{}", robot.body.name, self.process.kind);
        let words = Chance::words(robot.seed, &name);
        for (part, word) in ["high", "low", "step_high", "step_low"].iter().zip(words) {
            writer.start(format_args!("{field}.{part}"), format_args!("{word:#018x}ull"));
        }
    }
}

fn signals(writer: &mut Writer, left: impl Display, right: impl Display) {
    writer.line(format_args!("signals[0] = {left};"));
    writer.line(format_args!("signals[1] = {right};"));
}

/// Signals of 0 as long as a condition does not hold.
fn stand_unless(writer: &mut Writer, condition: &str) {
    writer.block(format_args!("if (!({condition}))"), |writer| {
        writer.line("signals[0] = signals[1] = 0;");
        writer.line("return;");
    });
}

/// Signals for a bend to the left by `leftwards`.
fn bend(writer: &mut Writer, forward: f64) {
    signals(writer, format_args!("{} - leftwards", c(forward)), format_args!("{} + leftwards", c(forward)));
}

/// The numbers of `struct brain_caution`.
fn caution(p: &avoid::Parameters) -> String {
    let numbers = [
        p.forward,
        p.creep,
        p.turn,
        p.slow_reading,
        p.turn_reading,
        p.clear_reading,
        p.stroll_rate_hz,
        p.stop_stroll_rate_hz,
    ];
    let numbers = numbers.map(|number| c(number).to_string()).join(", ");
    let stale_ns = (p.stale_s * 1e9) as u64;
    format!("{numbers}, {stale_ns}ull")
}

/// The default parameters with the changes of a table, which was checked when the brain was made.
fn set<P: Default>(known: &[Parameter<P>], table: &Table) -> P {
    let mut parameters = P::default();
    for parameter in known {
        let given = table.get(parameter.name).and_then(|value| match value {
            Value::Float(number) => Some(*number),
            Value::Integer(number) => Some(*number as f64),
            Value::String(_) | Value::Boolean(_) | Value::Datetime(_) | Value::Array(_) | Value::Table(_) => {
                None
            }
        });
        if let Some(number) = given {
            *(parameter.field)(&mut parameters) = number;
        }
    }
    parameters
}

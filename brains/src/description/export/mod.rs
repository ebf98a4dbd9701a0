//! A described brain as one C file: the standard form in which brains go to real robots (Wahde 2016, Sections 3.1 and 3.2.7): its export.
//!
//! ```text
//! z = sense(readings),   ḣ = feel(z, h),   choice = decide(z, h),   signals = act(choice, readings)      (Section 8.1)
//! ```
//!
//! The file allocates nothing, needs C99 and compiles for a PC and for an ATmega328P, whose `double` has 32 bits. On a PC its
//! decisions are those of the brain in this program, to the bit, if the compiler fuses no multiplication with an addition
//! (`-ffp-contract=off`): the one function of the maths library that brains need, tanh, is written out in the file, and so is the generator
//! of random numbers. Fixed parts are files in `c/`; what depends on the description is written by [`Writer`].
//!
//! *Deviations.* The notes ask for a standard form and describe none. A turn of the exported brain is a turn in which a message has come and the
//! cable is free: a brain on its robot has no cable, so nothing of a [throttle](crate::throttle) is exported. Cognitive processes, and
//! behaviours that drive by the pose that these believe, keep maps and lists of any length, and are refused.

mod decision;
mod fragment;
mod internal;
mod motors;
mod policy;
mod senses;
#[cfg(test)]
mod tests;
mod writer;

use baudbot_brain::Body;

use super::raw::Raw;
use super::{DescriptionError, build};
use crate::composed::{Composed, Decision};
use crate::registry::Registry;
use crate::senses::Mapping;
use fragment::Fragment;
use motors::{Activation, Exported};
use writer::{Writer, c, plain};

/// The robot for which a brain is exported.
pub(super) struct Robot<'a> {
    pub(super) body: &'a Body,
    pub(super) seed: u64,
}

impl Robot<'_> {
    /// The place of a sensor's first value among the values of all sensors.
    fn value(&self, sensor: usize) -> usize {
        self.body.sensors[..sensor].iter().map(baudbot_brain::Sensor::values).sum()
    }

    /// The number of values of all sensors.
    fn values(&self) -> usize {
        self.value(self.body.sensors.len())
    }

    fn has_heard(&self, sensor: usize) -> String {
        format!("brain->has_heard[{sensor}]")
    }

    /// The first value of a sensor's last reading.
    fn reading(&self, sensor: usize) -> String {
        format!("readings->values[{}]", self.value(sensor))
    }
}

/// The C file of a description.
pub(super) fn file(raw: &Raw, robot: &Robot<'_>) -> Result<String, DescriptionError> {
    let mut writer = Writer::default();
    let turn = match &raw.policy {
        Some(policy) => policy::write(&mut writer, &policy.policy(robot.body)?, robot)?,
        None => processes(&mut writer, raw, robot)?,
    };
    Ok(writer.finish(&head(raw, robot), &turn))
}

/// All of a brain of processes; the text of `brain_turn`.
fn processes(writer: &mut Writer, raw: &Raw, robot: &Robot<'_>) -> Result<String, DescriptionError> {
    let exported = raw.motor.iter().enumerate();
    let exported: Vec<_> =
        exported.map(|(place, (name, process))| Exported { place, name, process }).collect();
    let brain = checked(raw, robot, &exported)?;
    hear(writer, raw.state_variables.values().any(|variable| variable.stale_s.is_some()));
    let (sensed, motors) = (brain.senses.variables.len(), exported.len());
    let variables = sensed + brain.internal.variables.len();
    if variables > 0 {
        writer.field(format_args!("brain_real z[{variables}]"), "the state variables");
    }
    if sensed > 0 {
        senses::write(writer, &brain.senses, robot);
    }
    if variables > sensed {
        internal::write(writer, &brain.internal, sensed);
    }
    writer.field(format_args!("uint8_t driving[{motors}]"), "whether each motor behaviour drives");
    writer.field("uint16_t active", "the motor behaviour that was chosen");
    writer.start("active", u16::MAX);
    writer.field("brain_real signals[2]", "of the left and the right motor");
    let fixed = exported.iter().filter(|motor| motor.process.kind == "fixed_action");
    let fixed: Vec<_> = fixed.map(|motor| motor.place).collect();
    decision::write(writer, &brain.decision, &brain.motors, &fixed);
    let activations = exported.iter().map(|motor| motor.write(writer, robot));
    let activations = activations.collect::<Result<Vec<_>, _>>()?;
    activate(writer, &brain.decision, &activations);
    act(writer, &brain.decision, motors);
    Ok(turn(writer, robot.body, sensed > 0, variables > sensed))
}

/// The brain, if all of it can be exported.
fn checked(raw: &Raw, robot: &Robot<'_>, motors: &[Exported<'_>]) -> Result<Composed, DescriptionError> {
    if let Some(name) = raw.cognitive.keys().next() {
        let problem = "cognitive processes cannot be exported: they keep maps and lists of any length; leave it out if no behaviour \
                       needs it";
        return Err(DescriptionError::new(format!("cognitive.{name}"), problem));
    }
    if let Some(name) = raw.actuators.keys().next() {
        let problem = "signals for other actuators than the wheels cannot be exported but from a `[policy]`; leave them out";
        return Err(DescriptionError::new(format!("actuators.{name}"), problem));
    }
    motors.iter().try_for_each(Exported::check)?;
    let brain = build::brain(raw, robot.seed, robot.body, &Registry::standard())?;
    for variable in &brain.senses.variables {
        if let Mapping::Network(network) = &variable.mapping {
            senses::check(&format!("state_variables.{}.network", variable.name), network)?;
        }
    }
    Ok(brain)
}

/// The function `brain_hear`, which takes in what is new.
fn hear(writer: &mut Writer, with_times: bool) {
    writer.field("uint8_t has_heard[BRAIN_SENSORS]", "whether each sensor was ever read");
    if with_times {
        writer.field("uint64_t heard_ns[BRAIN_SENSORS]", "when each was read last");
    }
    let signature = "void brain_hear(struct brain *brain, const struct brain_readings *readings)";
    writer.function("What is new is taken in.", signature, |writer| {
        writer.line("uint16_t i;");
        writer.block("for (i = 0; i < BRAIN_SENSORS; i++)", |writer| {
            writer.line("if (!readings->is_new[i]) continue;");
            writer.line("brain->has_heard[i] = 1;");
            if with_times {
                writer.line("brain->heard_ns[i] = readings->at_ns;");
            }
        });
    });
}

/// The function `brain_activate`, which leaves what is no longer chosen, and enters what is.
fn activate(writer: &mut Writer, decision: &Decision, activations: &[Activation]) {
    let signature =
        "void brain_activate(struct brain *brain, const struct brain_readings *readings, uint16_t chosen)";
    writer.function("The chosen behaviour is entered, and others are left.", signature, |writer| {
        writer.line("uint8_t drives;");
        writer.line("(void)readings;");
        writer.line("brain->active = chosen;");
        for (place, Activation { enter, leave }) in activations.iter().enumerate() {
            let drives = match decision {
                Decision::Cooperative(_) => format!("brain->shares[{place}] > 0"),
                Decision::Utility { .. }
                | Decision::Machine(_)
                | Decision::Layers(_)
                | Decision::Tree(_)
                | Decision::Hydraulic(_) => format!("chosen == {place}"),
            };
            writer.line(format_args!("drives = {drives};"));
            for (statement, before, now) in [(enter, "!", ""), (leave, "", "!")] {
                if !statement.is_empty() {
                    writer.line(format_args!(
                        "if ({now}drives && {before}brain->driving[{place}]) {statement}"
                    ));
                }
            }
            writer.line(format_args!("brain->driving[{place}] = drives;"));
        }
    });
}

/// The function `brain_act`: the steps of those that drive.
fn act(writer: &mut Writer, decision: &Decision, motors: usize) {
    let signature = "void brain_act(struct brain *brain, const struct brain_readings *readings)";
    let is_cooperative = matches!(decision, Decision::Cooperative(_));
    writer.function("Those that drive do their step.", signature, |writer| {
        for place in 0..motors {
            let signals =
                if is_cooperative { format!("brain->suggestions[{place}]") } else { "brain->signals".into() };
            writer.line(format_args!(
                "if (brain->driving[{place}]) brain_motor_{place}(brain, readings, {signals});"
            ));
        }
        if is_cooperative {
            writer.line("brain->signals[0] = brain->signals[1] = -0.0;");
            for (place, side) in (0..motors).flat_map(|place| [(place, 0), (place, 1)]) {
                writer.line(format_args!(
                    "brain->signals[{side}] += brain->shares[{place}] * brain->suggestions[{place}][{side}];"
                ));
            }
        }
    });
}

/// The text of `brain_turn`.
fn turn(writer: &mut Writer, body: &Body, senses: bool, feels: bool) -> String {
    writer.uses(Fragment::Since);
    writer.field("uint64_t turned_ns", "when the last turn was");
    writer.field("uint8_t has_turned", "whether there was one");
    let sense = if senses { "  brain_sense(brain, readings);\n" } else { "" };
    let feel = if feels { "  brain_feel(brain, seconds);\n" } else { "" };
    let condition = if feels { "if (!brain->is_dead) " } else { "" };
    let limit = body.signal_limit.map(|limit| {
        writer.uses(Fragment::Limit);
        format!("  brain_limit(signals, {});\n", c(limit))
    });
    let stop = if feels { "brain->is_dead || " } else { "" };
    format!(
        "  brain_real seconds = brain->has_turned ? brain_since(brain->turned_ns, readings->at_ns) : 0, signals[2];\n\
         \x20 brain->turned_ns = readings->at_ns;\n\
         \x20 brain->has_turned = 1;\n\
         \x20 brain_hear(brain, readings);\n{sense}{feel}\
         \x20 {condition}{{\n\
         \x20   brain_activate(brain, readings, brain_decide(brain, seconds));\n\
         \x20   brain_act(brain, readings);\n\
         \x20 }}\n\
         \x20 memcpy(signals, brain->signals, sizeof signals);\n\
         \x20 if ({stop}!isfinite(signals[0]) || !isfinite(signals[1])) signals[0] = signals[1] = 0;\n{}\
         \x20 command->left = signals[0];\n\
         \x20 command->right = signals[1];\n",
        limit.unwrap_or_default(),
    )
}

/// The head of the file: its manual, and its types.
fn head(raw: &Raw, robot: &Robot<'_>) -> String {
    let body = robot.body;
    let mut lines = String::new();
    for (place, sensor) in body.sensors.iter().enumerate() {
        let mut value = robot.value(place);
        for component in &sensor.components {
            let names = [&sensor.name, &component.name].map(|name| plain(name)).join(" ");
            let last = value + component.count - 1;
            let values = if last > value { format!("{value} to {last}") } else { value.to_string() };
            let unit = if component.unit == "1" { "ratio" } else { &component.unit };
            lines += &format!("     values[{values}], is_new[{place}]: {} ({})\n", names.trim(), plain(unit));
            value += component.count;
        }
    }
    let what = plain(&raw.description);
    let limit = body
        .signal_limit
        .map_or_else(|| "without a limit".to_owned(), |limit| format!("from -{0} to {0}", c(limit)));
    let actuators = match &raw.policy {
        Some(_) if !body.actuators.is_empty() => {
            format!("#define BRAIN_ACTUATORS {}\n", body.actuators.len())
        }
        Some(_) | None => String::new(),
    };
    MANUAL
        .replace("{what}", &what)
        .replace("{robot}", &plain(&body.name))
        .replace("{readings}", &lines)
        .replace("{limit}", &limit)
        .replace("{sensors}", &body.sensors.len().max(1).to_string())
        .replace("{values}", &robot.values().max(1).to_string())
        .replace("{actuators}", &actuators)
}

/// The begin of each file.
const MANUAL: &str = concat!(include_str!("c/manual.c"), include_str!("c/head.c"));

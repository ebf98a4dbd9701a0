//! A policy as the whole brain.

use super::super::DescriptionError;
use super::fragment::Fragment;
use super::senses::{buffers, check, layers, tables};
use super::writer::{Writer, c};
use super::{Robot, hear};
use crate::policy::Policy;

/// The network and the fields; the text of `brain_turn`.
///
/// # Errors
/// If the robot has no sensor, or a layer no neuron.
pub(super) fn write(
    writer: &mut Writer,
    policy: &Policy,
    robot: &Robot<'_>,
) -> Result<String, DescriptionError> {
    if policy.offset.is_empty() {
        return Err(DescriptionError::new(
            "policy",
            "has no inputs on a robot without sensors, and cannot be exported",
        ));
    }
    check("policy.layers", &policy.network)?;
    hear(writer, policy.max_age_s.is_some());
    tables(writer, "brain_policy", &policy.network);
    writer.table("brain_offset", policy.offset.iter());
    writer.table("brain_scale", policy.scale.iter());
    let (inputs, values, sensors) = (policy.offset.len(), robot.values(), robot.body.sensors.len());
    let signature = "void brain_answer(struct brain *brain, const struct brain_readings *readings, struct brain_command *command)";
    let meaning = "The answers of the network, to inputs and in signals of single precision.";
    writer.function(meaning, signature, |writer| {
        buffers(writer, inputs, &policy.network);
        writer.line("uint16_t i;");
        let value = "inputs[i] = readings->values[i];";
        writer.line(format_args!("for (i = 0; i < {values}; i++) {value}"));
        if let Some(max_age_s) = policy.max_age_s {
            ages(writer, sensors, values, max_age_s);
        }
        let scaled =
            "((brain_real)(float)inputs[i] - BRAIN_READ(brain_offset[i])) * BRAIN_READ(brain_scale[i])";
        writer.line(format_args!("for (i = 0; i < {inputs}; i++) inputs[i] = {scaled};"));
        let answers = layers(writer, "brain_policy", &policy.network);
        writer.line(format_args!("command->left = (float){answers}[0];"));
        writer.line(format_args!("command->right = (float){answers}[1];"));
        for other in 0..robot.body.actuators.len() {
            writer.line(format_args!("command->others[{other}] = (float){answers}[{}];", other + 2));
        }
        writer.line("(void)brain;");
    });
    Ok("  brain_hear(brain, readings);\n  brain_answer(brain, readings, command);\n".to_owned())
}

/// The ages of all readings as inputs, and which are new.
fn ages(writer: &mut Writer, sensors: usize, values: usize, max_age_s: f64) {
    writer.uses(Fragment::Since);
    writer.uses(Fragment::Min);
    let max_age_s = c(max_age_s);
    writer.block(format_args!("for (i = 0; i < {sensors}; i++)"), |writer| {
        let age_s = format!("brain_min(brain_since(brain->heard_ns[i], readings->at_ns), {max_age_s})");
        writer.line(format_args!("inputs[{values} + i] = brain->has_heard[i] ? {age_s} : {max_age_s};"));
        writer.line(format_args!("inputs[{values} + {sensors} + i] = readings->is_new[i] ? 1 : 0;"));
    });
}

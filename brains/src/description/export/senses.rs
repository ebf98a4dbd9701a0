//! State variables, and networks.

use baudbot_brain::SensorKind;

use super::super::DescriptionError;
use super::Robot;
use super::fragment::Fragment;
use super::writer::{Writer, c, plain};
use crate::network::Network;
use crate::senses::{Mapping, Senses, StateVariable};

/// The function `brain_sense`, which makes state variables of readings: Wahde 2016, Eqs. (8.1) to (8.3).
pub(super) fn write(writer: &mut Writer, senses: &Senses, robot: &Robot<'_>) {
    for (place, variable) in senses.variables.iter().enumerate() {
        self::variable(writer, place, variable, robot);
    }
    let signature = "void brain_sense(struct brain *brain, const struct brain_readings *readings)";
    writer.function("The state variables.", signature, |writer| {
        for place in 0..senses.variables.len() {
            writer.line(format_args!("brain->z[{place}] = brain_sense_{place}(brain, readings);"));
        }
    });
}

fn variable(writer: &mut Writer, place: usize, variable: &StateVariable, robot: &Robot<'_>) {
    let count = variable.sources.iter().map(|source| source.count()).sum();
    match &variable.mapping {
        Mapping::Sum(weights) => writer.table(format_args!("brain_weights_{place}"), weights.iter()),
        Mapping::Network(network) => tables(writer, &format!("brain_network_{place}"), network),
        Mapping::Min | Mapping::Max => {}
    }
    let signature = format!(
        "brain_real brain_sense_{place}(const struct brain *brain, const struct brain_readings *readings)"
    );
    writer.function(plain(&variable.name), signature, |writer| {
        let begin = match &variable.mapping {
            Mapping::Sum(_) => "-0.0",
            Mapping::Min | Mapping::Max => "NAN",
            Mapping::Network(_) => "0",
        };
        writer.line(format_args!("brain_real z = {begin}, value;"));
        if let Mapping::Network(network) = &variable.mapping {
            buffers(writer, count, network);
        }
        if variable.sources.iter().any(|source| source.count() != 1) {
            writer.line("uint16_t i;");
        }
        if matches!(variable.mapping, Mapping::Sum(_) | Mapping::Network(_)) {
            writer.line("uint16_t n = 0;");
        }
        inputs(writer, place, variable, robot);
        if let Mapping::Network(network) = &variable.mapping {
            let answers = layers(writer, &format!("brain_network_{place}"), network);
            writer.line(format_args!("z = {answers}[0];"));
        }
        writer.line("return z;");
    });
}

/// All inputs, one after the other.
fn inputs(writer: &mut Writer, place: usize, variable: &StateVariable, robot: &Robot<'_>) {
    for source in &variable.sources {
        let sensor = &robot.body.sensors[source.sensor];
        let first = robot.value(source.sensor);
        let beyond_m = sensor.range_m.filter(|_| sensor.kind == SensorKind::Laser);
        let mut is_there = format!("brain->has_heard[{}]", source.sensor);
        if let Some(stale_s) = variable.stale_s {
            writer.uses(Fragment::Since);
            let since = format!("brain_since(brain->heard_ns[{}], readings->at_ns)", source.sensor);
            is_there = format!("{is_there} && {since} <= {}", c(stale_s));
        }
        writer.each(first + source.values.start..first + source.values.end, |writer, i| {
            writer.line(format_args!("value = {is_there} ? readings->values[{i}] : 0;"));
            if let Some(beyond_m) = beyond_m {
                writer.line(format_args!("if (value < 0) value = {};", c(beyond_m)));
            }
            take(writer, place, &variable.mapping);
        });
    }
}

/// The effect of an input.
fn take(writer: &mut Writer, place: usize, mapping: &Mapping) {
    match mapping {
        Mapping::Sum(_) => writer.line(format_args!("z += BRAIN_READ(brain_weights_{place}[n++]) * value;")),
        Mapping::Min => {
            writer.uses(Fragment::Min);
            writer.line("z = brain_min(z, value);");
        }
        Mapping::Max => {
            writer.uses(Fragment::Max);
            writer.line("z = brain_max(z, value);");
        }
        Mapping::Network(_) => writer.line("inputs[n++] = value;"),
    }
}

/// C has no empty tables.
///
/// # Errors
/// If a layer has no neuron.
pub(super) fn check(path: &str, network: &Network) -> Result<(), DescriptionError> {
    let empty = network.layers.iter().position(Vec::is_empty);
    let error =
        |layer| DescriptionError::new(format!("{path}[{layer}]"), "has no neuron, and cannot be exported");
    empty.map_or(Ok(()), |layer| Err(error(layer)))
}

/// The weights of a network.
pub(super) fn tables(writer: &mut Writer, name: &str, network: &Network) {
    for (place, layer) in network.layers.iter().enumerate() {
        writer.table(format_args!("{name}_{place}"), layer.iter().flatten());
    }
}

/// The inputs and the answers of each layer, as variables of a function.
pub(super) fn buffers(writer: &mut Writer, inputs: usize, network: &Network) {
    writer.line(format_args!("brain_real inputs[{inputs}];"));
    for (place, layer) in network.layers.iter().enumerate() {
        writer.line(format_args!("brain_real answers_{place}[{}];", layer.len()));
    }
}

/// The calculation of a network from `inputs`; the name of its answers.
pub(super) fn layers(writer: &mut Writer, name: &str, network: &Network) -> String {
    writer.uses(Fragment::Layer);
    let mut from = "inputs".to_owned();
    for (place, layer) in network.layers.iter().enumerate() {
        let to = format!("answers_{place}");
        let inputs = layer.first().map_or(0, |weights| weights.len().saturating_sub(1));
        writer.line(format_args!("brain_layer({name}_{place}, {inputs}, {}, {from}, {to});", layer.len()));
        from = to;
    }
    from
}

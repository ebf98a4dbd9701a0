//! A policy: a small network that turns readings into signals, as a program has learnt it in an environment (crate
//! `baudbot-run`, `baudbot.gym` in Python).
//!
//! It has what an environment observes, in the same order and as coarsely, and answers when an environment would: at each
//! turn with a message, and after a second without any.

use baudbot_brain::{Action, Body, Brain, Protocol, Reading, Signals, Turn};

use crate::network::Network;

/// A policy for a robot.
///
/// The inputs of its network are all values of all sensors in the order of [`Body::sensors`], 0 where none has come yet. With
/// ages there follow the age of each sensor's reading in seconds, and then 1 for each sensor that is new and 0 for the others.
/// Its answers are the signals of the left and the right wheel, and of the other actuators.
#[derive(Clone, Debug, PartialEq)]
pub struct Policy {
    pub(crate) network: Network,
    pub(crate) offset: Vec<f64>,
    pub(crate) scale: Vec<f64>,
    /// Ages above it are given as it, in seconds; `None`: neither ages nor what is new are inputs.
    pub(crate) max_age_s: Option<f64>,
    /// The last values of all sensors.
    values: Vec<f64>,
    sensors: Vec<Heard>,
    is_asked: bool,
    /// The instant of the last answer, or else of the first turn.
    stepped_ns: Option<u64>,
}

/// The last reading of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Heard {
    /// The number of its values.
    count: usize,
    /// The instant at which the reading was sampled, if the message has it, and else of its arrival.
    sampled_ns: Option<u64>,
    is_new: bool,
}

impl Policy {
    /// A policy at its start. Each input is scaled: `(input - offset) * scale`. The network, the offsets and the scales must fit
    /// the [inputs](input_names) and the actuators of the body.
    pub(crate) fn new(
        body: &Body,
        network: Network,
        offset: Vec<f64>,
        scale: Vec<f64>,
        max_age_s: Option<f64>,
    ) -> Self {
        let heard = |count| Heard { count, sampled_ns: None, is_new: false };
        let sensors: Vec<_> = body.sensors.iter().map(|sensor| heard(sensor.values())).collect();
        Self {
            network,
            offset,
            scale,
            max_age_s,
            values: vec![0.0; sensors.iter().map(|sensor| sensor.count).sum()],
            sensors,
            is_asked: body.firmware.period_ns.is_none(),
            stepped_ns: None,
        }
    }

    fn take(&mut self, turn: &Turn) {
        let mut begin = 0;
        for (sensor, reading) in self.sensors.iter_mut().zip(&turn.readings) {
            let places = begin..begin + sensor.count;
            begin = places.end;
            let reading = reading.as_ref().filter(|reading| reading.readable);
            sensor.is_new = reading.is_some();
            let Some(Reading { values, sampled_at_ns, .. }) = reading else { continue };
            sensor.sampled_ns = Some(sampled_at_ns.unwrap_or(turn.at_ns));
            for (to, value) in self.values[places].iter_mut().zip(values) {
                *to = *value;
            }
        }
    }

    fn inputs(&self, at_ns: u64) -> Vec<f64> {
        let age_s = |sensor: &Heard, max_s: f64| {
            let age_s = |sampled_ns| at_ns.saturating_sub(sampled_ns) as f64 * 1e-9;
            sensor.sampled_ns.map_or(max_s, age_s).min(max_s)
        };
        let ages_s = self.max_age_s.map(|max_s| self.sensors.iter().map(move |sensor| age_s(sensor, max_s)));
        let news = self.sensors.iter().map(|sensor| f64::from(u8::from(sensor.is_new)));
        let news = self.max_age_s.map(|_| news);
        let inputs = self.values.iter().copied();
        let inputs = inputs.chain(ages_s.into_iter().flatten()).chain(news.into_iter().flatten());
        let scales = self.offset.iter().zip(&self.scale);
        inputs.zip(scales).map(|(input, (offset, scale))| (coarse(input) - offset) * scale).collect()
    }

    fn act(&self, at_ns: u64) -> Action {
        let mut signals = self.network.answers(self.inputs(at_ns)).into_iter().map(coarse);
        let (left, right) = (signals.next().unwrap_or(0.0), signals.next().unwrap_or(0.0));
        Action { signals: Some(Signals { left, right }), ..Action::wait() }.with_others(signals.collect())
    }
}

impl Brain for Policy {
    fn step(&mut self, turn: &Turn) -> Action {
        let is_first = self.stepped_ns.is_none();
        let stepped_ns = *self.stepped_ns.get_or_insert(turn.at_ns);
        if turn.is_answered() || turn.has_news() || turn.at_ns.saturating_sub(stepped_ns) >= PATIENCE_NS {
            self.take(turn);
            self.stepped_ns = Some(turn.at_ns);
            return self.act(turn.at_ns).until_message_or(turn.at_ns + PATIENCE_NS);
        }
        // The bare protocol has no question but a command.
        let asks = is_first && self.is_asked && !matches!(turn.body.firmware.protocol, Protocol::Bare { .. });
        let action = if asks { Action::poll() } else { Action::wait() };
        action.until_message_or(stepped_ns + PATIENCE_NS)
    }
}

/// The names of the inputs of a policy for this robot, in order: `odometer.x_m`, `laser.3`, `age of laser`, `laser is
/// new`.
pub fn input_names(body: &Body, with_ages: bool) -> Vec<String> {
    let mut names = Vec::new();
    for sensor in &body.sensors {
        for component in &sensor.components {
            let of =
                [sensor.name.as_str(), component.name.as_str()].into_iter().filter(|part| !part.is_empty());
            let name = of.collect::<Vec<_>>().join(".");
            match component.count {
                1 => names.push(name),
                count => names.extend((0..count).map(|i| format!("{name}.{i}"))),
            }
        }
    }
    let sensors = body.sensors.iter().filter(|_| with_ages);
    names.extend(sensors.clone().map(|sensor| format!("age of {}", sensor.name)));
    names.extend(sensors.map(|sensor| format!("{} is new", sensor.name)));
    names
}

/// The number in the precision of an environment's arrays, which is single.
fn coarse(number: f64) -> f64 {
    f64::from(number as f32)
}

/// The longest wait for a message, in nanoseconds of simulated time, as in an environment: a lost message does not
/// come.
const PATIENCE_NS: u64 = 1_000_000_000;

#[cfg(test)]
mod tests;

//! The default beginning of a diagram of a program of the user's own: the program first reads a sensor and then makes
//! a wheel do otherwise, both in one round of its main loop. It is found in a run of its own, edge by edge, so that
//! it does not depend on the drawing.

use baudbot_plot::quantity::handy;
use baudbot_plot::timing::ms;
use baudbot_sim::chip::{By, ChipSpec, Edge, Level, Line, Net, Seen, WheelPins};
use baudbot_sim::model::RobotSpec;
use baudbot_sim::timeline::{Event, What};

use super::record::Recorded;
use super::ticks::Tick;

/// The event with which the diagram begins.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Begins {
    /// A round of the main loop in which the program reacts to a reading.
    Reacts {
        /// The instant at which the round begins, when the sensor is read last before the change, and when that is, in
        /// nanoseconds.
        round_ns: u64,
        read_ns: u64,
        change_ns: u64,
        /// The sensor and the wheel, as the end of a sentence.
        what: String,
    },
    /// The first thing that the program does, as the end of a sentence.
    Does { at_ns: u64, what: String },
    /// The program does nothing, and the diagram begins with the start.
    Start,
}

impl Begins {
    /// Runs a world for as long as needed.
    pub(super) fn find(robot: &RobotSpec, chip: &ChipSpec, mut tick: Tick<'_>) -> anyhow::Result<Self> {
        let (mut search, mut fresh) = (Search::new(robot, chip), Recorded::default());
        let mut now_ns = 0;
        while now_ns < PATIENCE_NS && search.reaction.is_none() {
            let Some(now) = tick(&mut fresh)? else { break };
            now_ns = now;
            search.look(&std::mem::take(&mut fresh));
        }
        Ok(search.reaction.or(search.first).unwrap_or(Self::Start))
    }

    /// The begin of a window that is so long: a bit before the round, or before the reading if the round is longer than the window.
    pub(super) fn window_ns(&self, span_ns: u64) -> u64 {
        let lead_ns = span_ns / 10;
        let at_ns = match *self {
            Self::Reacts { round_ns, read_ns, change_ns, .. } => {
                let is_seen = |from: &u64| change_ns - *from < span_ns - 2 * lead_ns;
                [round_ns, read_ns].into_iter().find(is_seen).unwrap_or(change_ns)
            }
            Self::Does { at_ns, .. } => at_ns,
            Self::Start => 0,
        };
        at_ns.saturating_sub(lead_ns)
    }

    /// The words for it in the picture.
    pub(super) fn in_words(&self) -> String {
        match self {
            Self::Reacts { round_ns, what, .. } => {
                format!(
                    "In the round of its main loop that begins at {} ms, the program {what}.",
                    ms(*round_ns, 3)
                )
            }
            Self::Does { at_ns, what } => format!("At {} ms, the program {what}.", ms(*at_ns, 3)),
            Self::Start => format!(
                "Within {} s the program sends no character and drives no wheel: this is the start.",
                handy(PATIENCE_NS as f64 * 1e-9)
            ),
        }
    }
}

/// The length of the window, in nanoseconds, with steps of this length.
pub(super) fn span_ns(step_ns: u64) -> u64 {
    step_ns.saturating_mul(3).max(LEAST_NS)
}

/// The events by now.
struct Search<'a> {
    robot: &'a RobotSpec,
    chip: &'a ChipSpec,
    wheels: WheelPins,
    /// The begin of the round of the main loop, and the loop, if they are known.
    round: Option<(u64, u32)>,
    /// The last reading in it.
    read: Option<(u64, String)>,
    /// The first reaction in it: if the loop comes round again, it is the main loop.
    found: Option<Begins>,
    reaction: Option<Begins>,
    /// The first deed of all.
    first: Option<Begins>,
}

/// Something that happens.
enum Happening {
    Round(u32),
    Read(String),
    Changed(Net),
    Sent,
    Driven(Net),
}

impl<'a> Search<'a> {
    fn new(robot: &'a RobotSpec, chip: &'a ChipSpec) -> Self {
        let wheels = WheelPins::new(chip);
        Self { robot, chip, wheels, round: None, read: None, found: None, reaction: None, first: None }
    }

    /// Takes what has happened in a tick.
    fn look(&mut self, fresh: &Recorded) {
        let read = |event: &Event| Some((event.start.as_ns(), self.reading(event.what)?));
        let mut all: Vec<_> = fresh.events.iter().filter_map(read).collect();
        for edge in &fresh.edges {
            all.extend(self.wheels.take(edge).map(|net| (edge.at_ns, Happening::Changed(net))));
            all.extend(self.seen(edge).map(|happening| (edge.at_ns, happening)));
        }
        all.sort_by_key(|(at_ns, _)| *at_ns);
        all.into_iter().for_each(|(at_ns, happening)| self.take(at_ns, happening));
    }

    /// A reading that the program has asked for.
    fn reading(&self, what: What) -> Option<Happening> {
        let What::Acquire { sensor } = what else { return None };
        let place = usize::from(sensor);
        let sensor = self.robot.sensors.get(place).filter(|_| self.chip.asks_for(place))?;
        Some(Happening::Read(sensor.name.clone()))
    }

    fn seen(&self, edge: &Edge) -> Option<Happening> {
        match edge.seen {
            Seen::Level { pin, by: By::Part, .. } => Some(Happening::Read(self.label(Net::Pin(pin)))),
            Seen::Level { pin, level: Level::High, by: By::Chip | By::Shape } => {
                let net = Net::Pin(pin);
                self.chip.turns_a_wheel(net).then_some(Happening::Driven(net))
            }
            Seen::Sends(Some(_)) => Some(Happening::Sent),
            Seen::Round(over) => Some(Happening::Round(over.head)),
            Seen::Level { .. }
            | Seen::Converted { .. }
            | Seen::Sends(None)
            | Seen::Receives(_)
            | Seen::Shape { .. } => None,
        }
    }

    fn take(&mut self, at_ns: u64, happening: Happening) {
        match happening {
            Happening::Round(head) => self.begin_round(at_ns, head),
            Happening::Read(what) => self.read = Some((at_ns, what)),
            Happening::Changed(net) => self.react(at_ns, net),
            Happening::Sent => self.does(at_ns, || "sends its first character".to_owned()),
            Happening::Driven(net) => {
                let label = self.label(net);
                self.does(at_ns, || format!("first drives {label}"));
            }
        }
    }

    fn begin_round(&mut self, at_ns: u64, head: u32) {
        let found = self.found.take().filter(|_| self.round.is_some_and(|(_, before)| before == head));
        self.reaction = self.reaction.take().or(found);
        (self.round, self.read) = (Some((at_ns, head)), None);
    }

    /// The program makes a wheel do otherwise.
    fn react(&mut self, change_ns: u64, net: Net) {
        if let (Some((round_ns, _)), Some((read_ns, read)), None) = (self.round, &self.read, &self.found) {
            let what = format!("reads {read} and changes {}", self.label(net));
            self.found = Some(Begins::Reacts { round_ns, read_ns: *read_ns, change_ns, what });
        }
    }

    fn does(&mut self, at_ns: u64, what: impl FnOnce() -> String) {
        if self.first.is_none() {
            self.first = Some(Begins::Does { at_ns, what: what() });
        }
    }

    fn label(&self, net: Net) -> String {
        let signals = self.chip.signals();
        let signal = signals.iter().find(|signal| signal.line == Line::Wire(net));
        signal.map_or_else(|| net.to_string(), baudbot_sim::chip::Signal::label)
    }
}

/// So long it is waited for something that the program does, in nanoseconds.
const PATIENCE_NS: u64 = 10_000_000_000;
/// The window is so long at least, in nanoseconds: a line of text takes as long at 9600 baud.
const LEAST_NS: u64 = 20_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    fn reaction(round_ms: u64, read_ms: u64, change_ms: u64) -> Begins {
        let [round_ns, read_ns, change_ns] = [round_ms, read_ms, change_ms].map(|ms| ms * 1_000_000);
        Begins::Reacts { round_ns, read_ns, change_ns, what: String::new() }
    }

    #[test]
    fn a_window_has_the_whole_reaction_if_it_has_room_for_it() {
        let from_ms = |begins: Begins| begins.window_ns(30_000_000) / 1_000_000;
        assert_eq!(from_ms(reaction(100, 101, 110)), 97);
        assert_eq!(from_ms(reaction(100, 190, 200)), 187, "the round is longer");
        assert_eq!(from_ms(reaction(100, 110, 200)), 197, "so is the way from the reading to the change");
        assert_eq!(from_ms(reaction(1, 2, 3)), 0);
        assert_eq!(from_ms(Begins::Does { at_ns: 8_000_000, what: String::new() }), 5);
        assert_eq!(from_ms(Begins::Start), 0);
        for span_ns in [0, 1, 9, u64::MAX] {
            assert!(reaction(1, 2, 3).window_ns(span_ns) <= 3_000_000);
        }
    }
}

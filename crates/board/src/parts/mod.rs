//! The parts, one kind a file: the numbers of their data sheets, and their behaviour.

mod bridge;
mod compass;
mod encoder;
mod kind;
mod led;
mod meter;
mod piezo;
mod range_finder;
mod reflectance;
mod servo;
mod shield;
mod sonar;
mod switch;
mod voltage;

use baudbot_avr::{Direction, Drive, External, Pwm};
use serde::{Deserialize, Serialize};

pub use bridge::{BridgeKind, Decay, MotorDrive};
pub use compass::Compass;
pub use encoder::{Channels, Encoder};
pub use kind::Kind;
pub use led::{Led, LitBy};
pub use piezo::Piezo;
pub use range_finder::RangeFinder;
pub use reflectance::Reflectance;
pub use servo::{Pulse, ServoKind};
pub use shield::ShieldMotor;
pub use sonar::{HcSr04, Ping};
pub use switch::{Pull, Switch};
pub use voltage::Voltage;

use crate::clock::ChipClock;
use crate::physics::{PartId, Physics};
use crate::role::Role;

/// The signal of the chip on a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Signal {
    Steady(Drive),
    /// A timer's signal, by its shape.
    Pwm(Pwm),
}

impl Signal {
    /// The fraction of time in which a logic input is high. One that nothing drives is low.
    pub(crate) fn duty(self) -> f64 {
        match self {
            Self::Steady(Drive::High | Drive::PullUp) => 1.0,
            Self::Steady(Drive::Low | Drive::HighImpedance) => 0.0,
            Self::Pwm(Pwm { high, period }) => high as f64 / period.max(1) as f64,
        }
    }

    /// Whether an output is high now; unknown from the shape of a signal.
    pub(crate) fn is_high(self) -> bool {
        self == Self::Steady(Drive::High)
    }
}

/// A part begins to do something else to a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Change {
    /// The cycle.
    pub(crate) at: u64,
    pub(crate) role: Role,
    pub(crate) external: External,
}

/// A part's remark on a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Remark {
    /// A trigger pulse is too short for the sensor.
    ShortTrigger,
    /// A trigger pulse is shorter than the data sheet promises to be enough.
    WeakTrigger,
    /// A pulse is none for a servo.
    OddServoPulse,
}

/// An instant as the chip and as the world counts it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Instant<'a> {
    pub(crate) cycle: u64,
    pub(crate) clock: &'a ChipClock,
}

impl Instant<'_> {
    pub(crate) fn ns(self) -> u64 {
        self.clock.ns(self.cycle)
    }

    /// The first cycle that is so many nanoseconds later.
    pub(crate) fn after(self, ns: u64) -> u64 {
        self.clock.cycle(self.ns().saturating_add(ns))
    }
}

/// A part with its state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Part {
    Voltage(Voltage),
    Reflectance(reflectance::State),
    Switch(switch::State),
    Encoder(encoder::State),
    Sonar(sonar::State),
    Bridge(bridge::State),
    Servo(servo::State),
    Led(led::State),
    Piezo(piezo::State),
    Compass(compass::State),
    RangeFinder(range_finder::State),
    Shield(shield::State),
}

impl Part {
    pub(crate) fn new(kind: &Kind) -> Self {
        match *kind {
            Kind::Voltage(voltage) => Self::Voltage(voltage),
            Kind::Reflectance(_) => Self::Reflectance(reflectance::State::default()),
            Kind::Switch(switch) => Self::Switch(switch::State::new(switch)),
            Kind::Encoder(encoder) => Self::Encoder(encoder::State::new(encoder)),
            Kind::Ping(_) => Self::Sonar(sonar::State::new(sonar::PING)),
            Kind::HcSr04(_) => Self::Sonar(sonar::State::new(sonar::HC_SR04)),
            Kind::Bridge(kind @ BridgeKind::Shield { motor, .. }) => {
                Self::Shield(shield::State::new(kind, motor))
            }
            Kind::Bridge(bridge) => Self::Bridge(bridge::State::new(bridge)),
            Kind::Servo(servo) => Self::Servo(servo::State::new(servo)),
            Kind::Led(led) => Self::Led(led::State::new(led)),
            Kind::Piezo(_) => Self::Piezo(piezo::State::default()),
            Kind::Compass(_) => Self::Compass(compass::State::new()),
            Kind::RangeFinder(_) => Self::RangeFinder(range_finder::State::default()),
        }
    }

    /// Whether a part of this kind can be in this state at an instant.
    pub(crate) fn is_possible(&self, kind: &Kind, now: Instant<'_>) -> bool {
        match (self, *kind) {
            (Self::Voltage(own), Kind::Voltage(voltage)) => *own == voltage,
            (Self::Reflectance(sensor), Kind::Reflectance(_)) => sensor.is_possible(now.cycle),
            (Self::Switch(own), Kind::Switch(switch)) => own.is_possible(switch, now.ns()),
            (Self::Encoder(own), Kind::Encoder(encoder)) => own.is_possible(encoder, now.ns()),
            (Self::Sonar(own), Kind::Ping(_)) => own.is_possible(sonar::PING, now.cycle),
            (Self::Sonar(own), Kind::HcSr04(_)) => own.is_possible(sonar::HC_SR04, now.cycle),
            (Self::Shield(own), Kind::Bridge(kind @ BridgeKind::Shield { motor, .. })) => {
                own.is_possible(kind, motor, now.cycle)
            }
            (Self::Bridge(own), Kind::Bridge(bridge)) => own.is_possible(bridge, now.cycle),
            (Self::Servo(own), Kind::Servo(servo)) => own.is_possible(servo, now),
            (Self::Led(own), Kind::Led(led)) => own.is_possible(led, now.cycle),
            (Self::Piezo(piezo), Kind::Piezo(_)) => piezo.is_possible(now.cycle),
            (Self::Compass(compass), Kind::Compass(_)) => compass.is_possible(now),
            (Self::RangeFinder(_), Kind::RangeFinder(_)) => true,
            _ => false,
        }
    }

    /// The bridge of a motor.
    pub(crate) const fn bridge(&self) -> Option<&bridge::State> {
        match self {
            Self::Bridge(bridge) => Some(bridge),
            Self::Shield(shield) => Some(&shield.bridge),
            Self::Voltage(_)
            | Self::Reflectance(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Sonar(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_)
            | Self::Compass(_)
            | Self::RangeFinder(_) => None,
        }
    }

    /// The shortest time between an act of the chip on a wire and the part's answer on one, in nanoseconds.
    pub(crate) fn reaction_ns(&self) -> u64 {
        match self {
            Self::Reflectance(_) => reflectance::REACTION_NS,
            Self::Sonar(sonar) => sonar.reaction_ns(),
            Self::Compass(_) => compass::MEASUREMENT_NS,
            Self::Voltage(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Bridge(_)
            | Self::Shield(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_)
            | Self::RangeFinder(_) => u64::MAX,
        }
    }

    /// A step begins.
    pub(crate) fn begin<P: Physics>(&mut self, id: PartId, at_ns: u64, physics: &mut P) {
        match self {
            Self::Switch(switch) => switch.begin(physics.is_pressed(id, at_ns), at_ns),
            Self::Encoder(encoder) => encoder.begin(physics.wheel(id, at_ns), at_ns),
            Self::Voltage(_)
            | Self::Reflectance(_)
            | Self::Sonar(_)
            | Self::Bridge(_)
            | Self::Shield(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_)
            | Self::Compass(_)
            | Self::RangeFinder(_) => {}
        }
    }

    /// Measures what is due up to a cycle.
    pub(crate) fn prepare<P: Physics>(&mut self, id: PartId, until: Instant<'_>, physics: &mut P) {
        match self {
            Self::Reflectance(sensor) => sensor.prepare(until.clock, |at| physics.discharge_ns(id, at)),
            Self::Sonar(sonar) => sonar.prepare(until, |at| physics.echo_ns(id, at)),
            Self::Compass(compass) => compass.prepare(until, |at| physics.gauss(id, at)),
            Self::Voltage(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Bridge(_)
            | Self::Shield(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_)
            | Self::RangeFinder(_) => {}
        }
    }

    /// The part's next change of a wire, as far as it is known.
    pub(crate) fn next_change(&self, clock: &ChipClock) -> Option<Change> {
        match self {
            Self::Reflectance(sensor) => sensor.next_change(),
            Self::Switch(switch) => switch.next_change(clock),
            Self::Encoder(encoder) => encoder.next_change(clock),
            Self::Sonar(sonar) => sonar.next_change(),
            Self::Voltage(_)
            | Self::Bridge(_)
            | Self::Shield(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_)
            | Self::Compass(_)
            | Self::RangeFinder(_) => None,
        }
    }

    /// The next change has been handed to the chip.
    pub(crate) fn change_taken(&mut self, clock: &ChipClock) {
        match self {
            Self::Reflectance(sensor) => sensor.change_taken(),
            Self::Switch(switch) => switch.change_taken(),
            Self::Encoder(encoder) => encoder.change_taken(clock),
            Self::Sonar(sonar) => sonar.change_taken(),
            Self::Voltage(_)
            | Self::Bridge(_)
            | Self::Shield(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_)
            | Self::Compass(_)
            | Self::RangeFinder(_) => {}
        }
    }

    /// The cycle at which it will do something by itself.
    pub(crate) fn next_event(&self, clock: &ChipClock) -> Option<u64> {
        let change = self.next_change(clock).map(|change| change.at);
        let due = match self {
            Self::Sonar(sonar) => sonar.due(),
            Self::Compass(compass) => compass.due(clock),
            Self::Voltage(_)
            | Self::Reflectance(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Bridge(_)
            | Self::Shield(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_)
            | Self::RangeFinder(_) => None,
        };
        change.into_iter().chain(due).min()
    }

    /// The chip does something else to the wire of a terminal.
    pub(crate) fn hear(&mut self, role: Role, signal: Signal, at: Instant<'_>) -> Option<Remark> {
        match self {
            Self::Sonar(sonar) => return sonar.hear(role, signal, at),
            Self::Servo(servo) => return servo.hear(signal, at),
            Self::Reflectance(sensor) => sensor.hear(signal, at.cycle),
            Self::Bridge(bridge) => bridge.hear(role, signal, at.cycle),
            Self::Shield(shield) => shield.hear(role, signal, at.cycle),
            Self::Led(led) => led.hear(signal, at.cycle),
            Self::Piezo(piezo) => piezo.hear(signal, at),
            Self::Voltage(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Compass(_)
            | Self::RangeFinder(_) => {}
        }
        None
    }

    /// A step is over.
    pub(crate) fn finish(&mut self, now: u64) {
        match self {
            Self::Bridge(bridge) => bridge.finish(now),
            Self::Shield(shield) => shield.bridge.finish(now),
            Self::Led(led) => led.finish(now),
            Self::Voltage(_)
            | Self::Reflectance(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Sonar(_)
            | Self::Servo(_)
            | Self::Piezo(_)
            | Self::Compass(_)
            | Self::RangeFinder(_) => {}
        }
    }

    /// A master has sent its address on the I²C bus; the answer is whether it acknowledges.
    pub(crate) fn bus_address(&mut self, direction: Direction, at: u64) -> bool {
        match self {
            Self::Compass(compass) => {
                compass.address(direction);
                true
            }
            Self::RangeFinder(finder) => finder.address(direction, at),
            Self::Voltage(_)
            | Self::Reflectance(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Sonar(_)
            | Self::Bridge(_)
            | Self::Shield(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_) => false,
        }
    }

    /// A master sends it a byte; the answer is whether it acknowledges.
    pub(crate) fn bus_write<P: Physics>(
        &mut self,
        id: PartId,
        byte: u8,
        at: Instant<'_>,
        physics: &mut P,
    ) -> bool {
        match self {
            Self::Compass(compass) => {
                compass.write(byte, at);
                true
            }
            Self::RangeFinder(finder) => {
                finder.write(byte, at, |at_ns| physics.echo_ns(id, at_ns));
                true
            }
            Self::Voltage(_)
            | Self::Reflectance(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Sonar(_)
            | Self::Bridge(_)
            | Self::Shield(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_) => false,
        }
    }

    /// A master reads a byte of it. A bus that nothing pulls down is high.
    pub(crate) fn bus_read(&mut self, at: u64) -> u8 {
        match self {
            Self::Compass(compass) => compass.read(at),
            Self::RangeFinder(finder) => finder.read(),
            Self::Voltage(_)
            | Self::Reflectance(_)
            | Self::Switch(_)
            | Self::Encoder(_)
            | Self::Sonar(_)
            | Self::Bridge(_)
            | Self::Shield(_)
            | Self::Servo(_)
            | Self::Led(_)
            | Self::Piezo(_) => 0xFF,
        }
    }
}

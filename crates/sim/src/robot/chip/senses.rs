//! The feelings of the parts on a chip's pins: the robot's sensors, read when the program asks.

use baudbot_board::{PartId, Physics, Wheel};
use baudbot_geometry::math;

use super::super::Recorder;
use crate::chip::{Attached, ChipSpec, Side};
use crate::drive::Wheels;
use crate::link::Link;
use crate::microcontroller::Microcontroller;
use crate::model::RobotSpec;
use crate::scene::Ping;
use crate::sensor::{Device, Measurement};
use crate::time::{SECOND_NS, SimTime};
use crate::timeline::What;

/// The robot around its chip.
pub(crate) struct Around<'a> {
    pub(crate) spec: &'a RobotSpec,
    /// The sensors.
    pub(crate) microcontroller: &'a mut Microcontroller,
    /// The measurement, but for the instant.
    pub(crate) measurement: Measurement<'a>,
    pub(crate) recorder: &'a mut Recorder,
    /// The pulse that the robot has sent in this tick.
    pub(crate) ping: &'a mut Option<Ping>,
}

impl<'a> Around<'a> {
    pub(super) fn link(&self) -> &'a Link {
        &self.spec.link
    }

    pub(super) fn tick_start(&self) -> SimTime {
        self.measurement.tick_start
    }

    pub(super) fn travel_m(&self) -> Wheels {
        self.measurement.motion.travel_m
    }

    pub(super) fn wheel_radius_m(&self) -> f64 {
        self.spec.drive.wheel_radius_m
    }

    /// Measures with a sensor; 0 if it has no such value.
    pub(super) fn value(&mut self, sensor: usize, value: usize, at: SimTime) -> f64 {
        self.measurement.now = at;
        let (values, ping) = self.microcontroller.sense(self.spec, sensor, &self.measurement);
        if ping.is_some() {
            *self.ping = ping;
        }
        self.recorder.note(at, at, What::Acquire { sensor: sensor as u16 });
        values.get(value).copied().unwrap_or(0.0)
    }

    /// Whether a part that is a switch, or is to the chip what a switch is, is closed at the start of the tick, if it was or was not
    /// before; `None` of other parts. Contacts bounce on the board.
    pub(super) fn is_closed(
        &mut self,
        spec: &ChipSpec,
        attached: Attached,
        was_closed: bool,
    ) -> Option<bool> {
        let start = self.tick_start();
        match attached {
            Attached::Contact { sensor } => {
                self.value(sensor, 0, start);
                Some(self.microcontroller.is_pressed(sensor))
            }
            Attached::Comparator(comparator) => {
                let source = comparator.source;
                let volts = source.volts(self.value(source.sensor, source.value, start));
                Some(comparator.is_low(volts, was_closed))
            }
            Attached::Control(i) => Some(spec.controls()[i].position(start) >= 0.5),
            Attached::Voltage(_)
            | Attached::Wheel(_)
            | Attached::Sonar { .. }
            | Attached::Reflectance { .. }
            | Attached::Compass { .. }
            | Attached::Motor(_)
            | Attached::WheelServo(_)
            | Attached::Actuator(_)
            | Attached::Board => None,
        }
    }
}

/// The sensors as a board asks for them.
pub(super) struct Senses<'a, 'b> {
    pub(super) spec: &'a ChipSpec,
    pub(super) around: &'a mut Around<'b>,
    pub(super) wheels: [Wheel; 2],
    pub(super) contacts: &'a [bool],
    pub(super) offset_ns: u64,
}

impl Senses<'_, '_> {
    fn attached(&self, part: PartId) -> Attached {
        self.spec.attached_to(part)
    }

    /// An instant of the board's in the tick: echoes are asked for a little ahead.
    fn at(&self, at_ns: u64) -> SimTime {
        let at = SimTime::from_ns(self.offset_ns.saturating_add(at_ns));
        at.max(self.around.measurement.tick_start).min(self.around.measurement.tick_end)
    }

    /// A value of the sensor that a part belongs to.
    fn value(&mut self, sensor: usize, value: usize, at_ns: u64) -> f64 {
        let at = self.at(at_ns);
        self.around.value(sensor, value, at)
    }
}

impl Physics for Senses<'_, '_> {
    fn volts(&mut self, part: PartId, at_ns: u64) -> f64 {
        match self.attached(part) {
            Attached::Voltage(source) => source.volts(self.value(source.sensor, source.value, at_ns)),
            Attached::Control(i) => SUPPLY_V * self.spec.controls()[i].position(self.around.tick_start()),
            Attached::Comparator(_)
            | Attached::Contact { .. }
            | Attached::Wheel(_)
            | Attached::Sonar { .. }
            | Attached::Reflectance { .. }
            | Attached::Compass { .. }
            | Attached::Motor(_)
            | Attached::WheelServo(_)
            | Attached::Actuator(_)
            | Attached::Board => 0.0,
        }
    }

    fn discharge_ns(&mut self, part: PartId, at_ns: u64) -> u64 {
        let Attached::Reflectance { sensor, value } = self.attached(part) else { return u64::MAX };
        let reflectance = self.value(sensor, value, at_ns).clamp(0.0, 1.0);
        // The current through the phototransistor grows with the light that comes back.
        let us = WHITE_US * math::exp((1.0 - reflectance) * math::ln(BLACK_US / WHITE_US));
        (us * 1e3) as u64
    }

    fn is_pressed(&mut self, part: PartId, _at_ns: u64) -> bool {
        self.contacts.get(part.index()).copied().unwrap_or(false)
    }

    fn wheel(&mut self, part: PartId, at_ns: u64) -> Wheel {
        let Attached::Wheel(side) = self.attached(part) else { return Wheel::default() };
        let wheel = match side {
            Side::Left => self.wheels[0],
            Side::Right => self.wheels[1],
        };
        let into_s = self.at(at_ns).since(self.around.measurement.tick_start) as f64 / SECOND_NS as f64;
        Wheel { angle_rad: wheel.angle_rad + wheel.rate_rad_s * into_s, ..wheel }
    }

    fn echo_ns(&mut self, part: PartId, at_ns: u64) -> Option<u64> {
        let Attached::Sonar { sensor } = self.attached(part) else { return None };
        let Device::Sonar(sonar) = &self.around.spec.sensors[sensor].device else { return None };
        let (max_m, sound_m_s) = (sonar.max_m, sonar.sound_m_s);
        let distance_m = self.value(sensor, 0, at_ns);
        (distance_m < max_m).then(|| (2.0 * distance_m / sound_m_s * SECOND_NS as f64 + 0.5) as u64)
    }

    fn gauss(&mut self, part: PartId, at_ns: u64) -> [f64; 3] {
        let Attached::Compass { sensor } = self.attached(part) else { return [0.0; 3] };
        let (sin, cos) = math::sin_cos(self.value(sensor, 0, at_ns));
        // The field points along the world's x axis; the chip's x axis looks ahead and its y axis to the left.
        [HORIZONTAL_GAUSS * cos, -HORIZONTAL_GAUSS * sin, -DOWN_GAUSS]
    }
}

/// The time that a QTR-1RC takes over white, and over black, in µs: Pololu's *QTR Reflectance Sensor Application
/// Note* has tens of µs to some milliseconds.
const WHITE_US: f64 = 50.0;
/// See [`WHITE_US`].
const BLACK_US: f64 = 2500.0;

/// The board's supply, in volts, between which and ground a potentiometer is.
const SUPPLY_V: f64 = 5.0;

/// The earth's field in the middle of Europe, in gauss: about 0.2 along the ground and 0.44 into it.
const HORIZONTAL_GAUSS: f64 = 0.2;
/// See [`HORIZONTAL_GAUSS`].
const DOWN_GAUSS: f64 = 0.44;

//! Touch: whiskers and bumpers (§1.2.4): 0 if nothing is touched, 1 if something is.
//!
//! On a real Boe-Bot the whisker pulls its pin low, so the program reads 0 when it touches: `active_low`. The
//! contact bounces: for a while after each change the reading is either, as likely as not.

use baudbot_geometry::{Fan, Ray};
use serde::{Deserialize, Serialize};

use super::{Measurement, Mount};
use crate::random::Stream;
use crate::time::SimTime;

/// A wire that sticks out.
#[derive(Clone, Debug, PartialEq)]
pub struct Whisker {
    /// Where it starts and which way it points.
    pub mount: Mount,
    /// How far it reaches, in metres.
    pub length_m: f64,
    /// How the contact is read.
    pub switch: Switch,
}

/// A bar along a part of the body's rim.
#[derive(Clone, Debug, PartialEq)]
pub struct Bumper {
    /// In the robot's centre, looking at the middle of the bar.
    pub mount: Mount,
    /// Directions in which the bar is felt.
    pub fan: Fan,
    /// How far the bar gives way, in metres: what is nearer to the rim presses it.
    pub travel_m: f64,
    /// How the contact is read.
    pub switch: Switch,
}

/// A contact that is open or closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Switch {
    /// A pressed contact reads 0, a free one 1.
    pub active_low: bool,
    /// How long it bounces after a change, in nanoseconds.
    pub bounce_ns: u64,
}

/// What the contact was at the last read, and since when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Contact {
    pressed: bool,
    changed: Option<SimTime>,
}

impl Whisker {
    pub(super) fn read(&self, at: &Measurement<'_>, contact: &mut Contact, stream: &mut Stream) -> f64 {
        let pose = self.mount.world_from_sensor(at);
        let ray = Ray { origin: pose.position, direction: pose.direction() };
        let touches = self.mount.look(at, &pose, self.length_m).cast(&ray).is_some();
        self.switch.read(touches, at, contact, stream)
    }
}

impl Bumper {
    pub(super) fn read(&self, at: &Measurement<'_>, contact: &mut Contact, stream: &mut Stream) -> f64 {
        let pose = self.mount.world_from_sensor(at);
        let reach = at.robot.drive.radius_m + self.travel_m;
        let eye = self.mount.look(at, &pose, reach);
        let pressed = eye.nearest(&pose, &self.fan).is_some();
        self.switch.read(pressed, at, contact, stream)
    }
}

impl Switch {
    fn read(self, pressed: bool, at: &Measurement<'_>, contact: &mut Contact, stream: &mut Stream) -> f64 {
        if pressed != contact.pressed {
            *contact = Contact { pressed, changed: Some(at.now) };
        }
        let bounces = contact.changed.is_some_and(|changed| at.now.since(changed) < self.bounce_ns);
        let closed = if bounces && at.noise { stream.below(2) == 1 } else { pressed };
        f64::from(u8::from(closed != self.active_low))
    }
}

//! Touch (§1.2.2): whiskers and bumpers (§1.2.4): 0 if nothing is touched, 1 if something is.
//!
//! On a real Boe-Bot the whisker pulls its pin low, so the program reads 0 when it touches: `active_low`. The
//! contact bounces: for a while after each change the reading is either, as likely as not.

use alloc::vec;
use alloc::vec::Vec;

use baudbot_geometry::{Fan, Ray};
use serde::{Deserialize, Serialize};

use super::kind::{Built, Component, Effect, Fit, Place, Rays, Sense, levels};
use super::style::{Style, Symbol};
use super::{Measurement, Mount};
use crate::random::Stream;
use crate::time::SimTime;
use baudbot_fields::number::{Between, Length, Millis, Number, Opening};
use baudbot_fields::{FieldError, Path};

/// A wire that sticks out.
#[derive(Clone, Debug, PartialEq)]
pub struct Whisker {
    /// The root and the direction.
    pub mount: Mount,
    /// The length, in metres.
    pub length_m: f64,
    /// The reading of the contact.
    pub switch: Switch,
}

/// A bar along a part of the body's rim.
#[derive(Clone, Debug, PartialEq)]
pub struct Bumper {
    /// In the robot's centre, looking at the middle of the bar.
    pub mount: Mount,
    /// Directions in which the bar is felt.
    pub fan: Fan,
    /// The travel of the bar, in metres: an object nearer to the rim presses it.
    pub travel_m: f64,
    /// The reading of the contact.
    pub switch: Switch,
}

/// A contact that is open or closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Switch {
    /// A pressed contact reads 0, a free one 1.
    pub active_low: bool,
    /// The time of bouncing after a change, in nanoseconds.
    pub bounce_ns: u64,
}

/// The state of the contact at the last read, and since when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Contact {
    pressed: bool,
    changed: Option<SimTime>,
}

impl Contact {
    /// Whether it was pressed at the last read, however it bounced.
    pub(crate) fn is_pressed(&self) -> bool {
        self.pressed
    }
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct WhiskerSheet {
    /// Length of the whisker.
    length_m: Number<Length>,
    /// A pressed contact reads 0, a free one 1, as on a Boe-Bot.
    #[serde(default)]
    active_low: bool,
    /// Time for which the contact bounces after each change, and reads 0 or 1 at random. Only with noise.
    #[serde(default)]
    bounce_ms: Bounce,
}

/// The fields of its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct BumperSheet {
    /// Angle of the rim that the bumper covers, centred on its bearing.
    opening_rad: Number<Opening>,
    /// Number of directions, from the robot's centre, in which the bumper feels.
    #[serde(default = "Rays::constant::<9>")]
    rays: Rays,
    /// Distance from the rim within which something presses the bumper. A robot stops short of an obstacle by up to
    /// the distance that it goes in a substep: with a smaller `travel_m` the bumper may feel nothing.
    #[serde(default = "travel_m")]
    travel_m: Number<Length>,
    /// A pressed contact reads 0, a free one 1.
    #[serde(default)]
    active_low: bool,
    /// Time for which the contact bounces after each change, and reads 0 or 1 at random. Only with noise.
    #[serde(default)]
    bounce_ms: Bounce,
}

type Bounce = Number<Millis<Between<0, 10_000>>>;

pub(super) fn travel_m() -> Number<Length> {
    Number::of(0.005)
}

impl Sense for Whisker {
    const NAME: &str = "whisker";
    const PLACE: Place = Place::Mounted;
    const STYLE: Style = Style { color: "#882255", symbol: Symbol::Line };
    const IS_ANALOG: bool = false;
    type Sheet = WhiskerSheet;
    type Memory = Contact;

    fn new(sheet: WhiskerSheet, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let switch = Switch { active_low: sheet.active_low, bounce_ns: sheet.bounce_ms.get() };
        let device = Self { mount: fit.mount, length_m: sheet.length_m.get(), switch };
        Ok(Built::new(device, levels(fit.bits, 1, 0.0, 1.0)))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "1")]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    fn range_m(&self) -> Option<f64> {
        Some(self.length_m)
    }

    fn read(
        &self,
        at: &Measurement<'_>,
        contact: &mut Contact,
        stream: &mut Stream,
        values: &mut [f64],
    ) -> Effect {
        let pose = self.mount.world_from_sensor(at);
        let ray = Ray { origin: pose.position, direction: pose.direction() };
        let touches = self.mount.look(at, &pose, self.length_m).cast(&ray).is_some();
        values[0] = self.switch.read(touches, at, contact, stream);
        Effect::NONE
    }

    fn unmeasured(&self, values: &mut [f64]) {
        values[0] = self.switch.free();
    }
}

impl Sense for Bumper {
    const NAME: &str = "bumper";
    const PLACE: Place = Place::Rim;
    const STYLE: Style = Style { color: "#332288", symbol: Symbol::Arc };
    const IS_ANALOG: bool = false;
    type Sheet = BumperSheet;
    type Memory = Contact;

    fn new(sheet: BumperSheet, _: &Path, fit: Fit<'_>) -> Result<Built<Self>, FieldError> {
        let device = Self {
            mount: fit.mount,
            fan: Fan::new(sheet.opening_rad.get(), sheet.rays.get().into()),
            travel_m: sheet.travel_m.get(),
            switch: Switch { active_low: sheet.active_low, bounce_ns: sheet.bounce_ms.get() },
        };
        Ok(Built::new(device, levels(fit.bits, 1, 0.0, 1.0)))
    }

    fn components(&self) -> Vec<Component> {
        vec![Component::one("", "1")]
    }

    fn mount(&self) -> Option<&Mount> {
        Some(&self.mount)
    }

    fn fan(&self) -> Option<&Fan> {
        Some(&self.fan)
    }

    fn read(
        &self,
        at: &Measurement<'_>,
        contact: &mut Contact,
        stream: &mut Stream,
        values: &mut [f64],
    ) -> Effect {
        let pose = self.mount.world_from_sensor(at);
        let reach = at.drive.radius_m + self.travel_m;
        let viewpoint = self.mount.look(at, &pose, reach);
        let pressed = viewpoint.nearest(&pose, &self.fan).is_some();
        values[0] = self.switch.read(pressed, at, contact, stream);
        Effect::NONE
    }

    fn unmeasured(&self, values: &mut [f64]) {
        values[0] = self.switch.free();
    }
}

impl Switch {
    /// The reading of a free contact.
    fn free(self) -> f64 {
        f64::from(u8::from(self.active_low))
    }

    fn read(self, pressed: bool, at: &Measurement<'_>, contact: &mut Contact, stream: &mut Stream) -> f64 {
        if pressed != contact.pressed {
            *contact = Contact { pressed, changed: Some(at.now) };
        }
        let bounces = contact.changed.is_some_and(|changed| at.now.since(changed) < self.bounce_ns);
        let closed = if bounces && at.noise { stream.below(2) == 1 } else { pressed };
        f64::from(u8::from(closed != self.active_low))
    }
}

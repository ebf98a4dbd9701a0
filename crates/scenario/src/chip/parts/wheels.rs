//! Wheels on pins: their encoders, and their motors' drivers.

use alloc::format;

use baudbot_board::{BridgeKind, Channels, Decay, Encoder, Kind, ServoKind, ShieldMotor};
use baudbot_fields::number::Number;
use baudbot_sim::chip::{Attached, Side};
use baudbot_sim::motor::Motors;
use baudbot_sim::sensor::{Device, Sensor};

use super::{Part, Result};

impl Part<'_> {
    pub(super) fn encoder(&self, sensor: &Sensor) -> Result<Kind> {
        let Device::Encoders(encoders) = &sensor.device else {
            return Err(self.path.error("is not an encoder"));
        };
        let channels = if self.uses("b") { Channels::Quadrature } else { Channels::Single };
        if encoders.quadrature && channels == Channels::Single {
            let problem = format!("`{0}` counts in quadrature: connect {0}.a and {0}.b", self.name);
            return Err(self.path.error(problem));
        }
        Ok(Kind::Encoder(Encoder { channels, counts_per_turn: encoders.counts_per_turn }))
    }

    pub(super) fn motor(&self, side: Side, motors: &Motors) -> Result<(Kind, Attached)> {
        match motors {
            Motors::Servo(_) => Ok((Kind::Servo(ServoKind::Continuous), Attached::WheelServo(side))),
            Motors::Dc(motor) if motor.inductance_h > 0.0 => Err(self.path.error(
                "a bridge at a chip's pins drives motors without `inductance_h` only; leave that out of motors",
            )),
            Motors::Dc(_) | Motors::Velocity(_) => Ok((Kind::Bridge(self.bridge(side)?), Attached::Motor(side))),
            Motors::Stepper(_) => Err(self
                .path
                .error("stepper motors have no driver for a chip's pins yet; take dc, velocity or servo")),
        }
    }

    /// The kind of the H-bridge, by its terminals.
    fn bridge(&self, side: Side) -> Result<BridgeKind> {
        let drop_v = self.option(|options| options.drop_v).map(Number::get);
        if ["latch", "clock", "data"].into_iter().any(|terminal| self.uses(terminal)) {
            let drop_v = drop_v.unwrap_or(BridgeKind::L293D_DROP_V);
            return Ok(BridgeKind::Shield { motor: self.shield_motor(side)?, drop_v });
        }
        let has_inputs = self.uses("in1") || self.uses("in2");
        Ok(match (has_inputs, self.uses("standby"), drop_v) {
            (true, true, None) => BridgeKind::TB6612,
            (true, true, Some(drop_v)) => BridgeKind::Tb6612 { drop_v },
            (true, false, None) => BridgeKind::L298N,
            (true, false, Some(drop_v)) => BridgeKind::L298N { drop_v },
            (false, _, drop_v) => {
                let decay = self.option(|options| options.decay).unwrap_or(Decay::Brake);
                BridgeKind::Directed { decay, drop_v: drop_v.unwrap_or(0.0) }
            }
        })
    }

    /// The motor of a shield that is meant: M1 on the left and M2 on the right, if nothing else is said.
    fn shield_motor(&self, side: Side) -> Result<ShieldMotor> {
        let numbered = self.terminals.iter().find_map(|used| Some((used.path, used.options.channel?)));
        let Some((path, channel)) = numbered else {
            return Ok(match side {
                Side::Left => ShieldMotor::M1,
                Side::Right => ShieldMotor::M2,
            });
        };
        let motor = usize::from(channel).checked_sub(1).and_then(|place| ShieldMotor::ALL.get(place));
        motor.copied().ok_or_else(|| path.field("channel").error(format!("must be 1 to 4, is {channel}")))
    }
}

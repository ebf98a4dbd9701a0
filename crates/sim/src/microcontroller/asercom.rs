//! The answers and commands of an e-puck's microcontroller: its letters, bound to the robot.
//!
//! The firmware takes a command, obeys it, answers, and only then takes the next one. A number in an answer is the code of the sensor
//! of its name, as the microcontroller last read it, or the encoder's count less that at which a program set it. Signal 1 is
//! 1000 steps/s, whatever the motors of the scenario make of it, and a faster wheel is one of signal 1.
//!
//! Deviations. The microcontroller reads no sensor that falls due after a command has come and before it has answered.
//! What the robot has no sensor for, and what takes no time here, is at the head of `crates/wire/src/asercom/mod.rs`.

use baudbot_wire::asercom::{Deed, FULL_STEPS_S};

use super::{Channel, Microcontroller, Taken, Tells};
use crate::link::LineCounters;
use crate::model::RobotSpec;
use crate::sensor::Sensor;
use crate::time::SimTime;

impl Microcontroller {
    /// Obeys a command whose last byte arrived at this instant. It is answered before what arrived later.
    pub(super) fn obey_letter(
        &mut self,
        spec: &RobotSpec,
        deed: Deed,
        arrived: SimTime,
        counters: &mut LineCounters,
    ) -> Taken {
        let taken = match deed {
            Deed::Drive(speeds) => self.roll(spec, speeds.map(|speed| f64::from(speed) / FULL_STEPS_S)),
            Deed::Reset => self.roll(spec, [0.0; 2]),
            Deed::SetSteps(_) => {
                self.free_at = self.free_at + spec.processor.obeying_ns;
                Taken::Poll
            }
            Deed::Answer | Deed::Calibrate => Taken::Poll,
            Deed::Unknown => Taken::Nonsense,
        };
        if taken == Taken::Nonsense {
            counters.bad_messages += 1;
        } else {
            counters.messages += 1;
        }
        let channels = &self.channels;
        let code = |name: &str, component| code(spec, channels, name, component);
        let Some(machine) = self.decoder.asercom_mut() else { return taken };
        match deed {
            Deed::SetSteps(steps) => machine.set_steps(code, steps),
            Deed::Calibrate => machine.calibrate(code),
            Deed::Drive(_) | Deed::Reset | Deed::Answer | Deed::Unknown => {}
        }
        if machine.owes() {
            self.frame.next = self.frame.next.min(arrived);
        }
        taken
    }

    /// Writes the answer that is owed. Returns how many bytes it is, and which readings are in it.
    pub(super) fn write_letters(&mut self, spec: &RobotSpec, out: &mut [u8]) -> (usize, Tells) {
        let channels = &self.channels;
        let code = |name: &str, component| code(spec, channels, name, component);
        let Some(machine) = self.decoder.asercom_mut() else { return (0, Tells::Nothing) };
        let (len, content) = machine.answer(code, out);
        (len, Tells::of(content.steps, content.proximity))
    }
}

/// The code of the last sample of the sensor of this name, if the robot has it. The firmware's numbers have 16 bits.
fn code(spec: &RobotSpec, channels: &[Channel], name: &str, component: usize) -> Option<i16> {
    let is_it = |sensor: &Sensor| sensor.is_on_wire() && sensor.name == name;
    let sensor = spec.sensors.iter().position(is_it)?;
    let encoding = spec.sensors[sensor].encodings.get(component)?;
    let value = channels[sensor].values.get(component).copied().unwrap_or(0.0);
    encoding.number(value).map(|code| code as i16)
}

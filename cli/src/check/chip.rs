//! The description of a robot's chip: its program, and what is on its pins.

use baudbot_plot::quantity::handy;
use baudbot_sim::chip::{Attached, ChipSpec, Kind, Net, Terminal};
use baudbot_sim::model::RobotSpec;

use crate::link;

/// The chip, who understands it, and its cable.
pub(super) fn describe(robot: &RobotSpec, chip: &ChipSpec) -> Vec<(&'static str, String)> {
    let (clock, part) = (chip.board().clock(), chip.board().chip().part());
    let off = match clock.deviation_ppb() {
        0 => String::new(),
        ppb => format!(
            ", in truth {} ppm {}",
            handy(f64::from(ppb.abs()) / 1e3),
            if ppb > 0 { "faster" } else { "slower" }
        ),
    };
    let mhz = f64::from(clock.hz()) / 1e6;
    let name = part.properties().name;
    let used =
        chip.board().chip().flash().iter().rposition(|&word| word != 0xffff).map_or(0, |last| 2 * (last + 1));
    let of = 2 * part.flash_words();
    let speaks = if chip.is_opaque() {
        "its own language; brains attach in RAW mode or through a serial port"
    } else if robot.firmware.protocol.repeats() {
        "bare values, as the scenario specifies"
    } else {
        "frames, as the scenario specifies"
    };
    vec![
        ("chip", format!("{name} at {mhz} MHz{off}")),
        ("program", format!("{used} of {of} bytes of flash")),
        ("speaks", speaks.to_owned()),
        ("link", link::text(&robot.link)),
    ]
}

/// The connections of each pin, in the pins' order.
pub(super) fn pins(chip: &ChipSpec) -> Vec<[String; 3]> {
    let wiring = chip.board().wiring();
    let mut wires: Vec<(Terminal, Net)> = wiring.wires().collect();
    wires.sort_by(|(_, a), (_, b)| a.order(*b));
    let row = |(terminal, net): (Terminal, Net)| {
        let placed = wiring.parts().find(|(id, _)| *id == terminal.part);
        let pin = match net {
            Net::Pin(_) => format!("{} ({net})", net.printed()),
            Net::AnalogOnly(_) | Net::Ground | Net::Supply => net.printed(),
        };
        let part = if let Some(Attached::Comparator(_)) = chip.attached().get(terminal.part.index()) {
            "comparator"
        } else {
            placed.map_or("", |(_, placed)| what(placed.kind()))
        };
        [pin, wiring.terminal_name(terminal), part.to_owned()]
    };
    wires.into_iter().map(row).collect()
}

fn what(kind: &Kind) -> &'static str {
    match kind {
        Kind::Voltage(_) => "voltage",
        Kind::Reflectance(_) => "capacitor that light discharges",
        Kind::Switch(_) => "switch",
        Kind::Encoder(_) => "encoder",
        Kind::Ping(_) => "PING)))",
        Kind::HcSr04(_) => "HC-SR04",
        Kind::Bridge(_) => "H-bridge",
        Kind::Servo(_) => "servo",
        Kind::Led(_) => "light-emitting diode",
        Kind::Piezo(_) => "piezo buzzer",
        Kind::Compass(_) => "HMC5883L on I²C",
        Kind::RangeFinder(_) => "SRF02 on I²C",
    }
}

//! Changes that make a robot quicker: each with its effect, its cost, and its form in a scenario.

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_wire::Encoding;

use super::report::Cost;
use crate::presets::{Preset, PresetKind, presets};
use baudbot_sim::fault::{Fault, FaultKind};
use baudbot_sim::firmware::{Mode, Protocol};
use baudbot_sim::link::{Adapter, Link, Uart};
use baudbot_sim::model::{Deadline, OnLate, RobotModel, RobotSpec};
use baudbot_sim::processor::Processor;
use baudbot_sim::sensor::{Device, Sensor};
use baudbot_sim::time::SECOND_NS;

/// A change.
#[derive(Clone, Copy, Debug)]
pub(super) enum Change {
    /// The latency timer of the chip in the cable, in nanoseconds.
    Latency(u64),
    /// Bits a second.
    Baud(u32),
    /// Bits a second of the sensors' own cables that carry too little.
    PortBauds(u32),
    /// Readings without their ages.
    NoAges,
    /// The notes' bare bytes.
    Bare,
    /// 8 bits a value, where there are more.
    FewerBits,
    /// The microcontroller speaks without being asked, every so many nanoseconds.
    Stream(u64),
    /// Another step Δt, in nanoseconds.
    Step(u64),
    /// An adapter without a timer.
    Cdc,
    /// USB all the way.
    Usb,
    /// Another microcontroller.
    Chip(&'static Preset),
    /// The brain moves to a laptop.
    Laptop,
    /// The robot does without this sensor.
    Drop(usize),
}

/// A robot and its step, as far as they have been changed.
#[derive(Clone, Debug)]
pub(super) struct Robot {
    pub(super) spec: RobotSpec,
    pub(super) step_ns: u64,
    pub(super) substeps: u32,
}

/// Rates that serial ports have.
pub(super) const BAUDS: [u32; 15] = [
    1200, 2400, 4800, 9600, 19_200, 38_400, 57_600, 115_200, 230_400, 250_000, 460_800, 500_000, 750_000,
    921_600, 1_000_000,
];

impl Robot {
    /// Changes of each kind, the smallest first.
    pub(super) fn changes(&self) -> Vec<Vec<Change>> {
        let [settings, rates, ports] = [self.latencies(), self.bauds(), self.port_bauds()];
        let firmware = [self.ages(), self.fewer_bits(), self.bare(), self.streams()];
        let [steps, adapters, usb] = [self.steps(), self.cables(), self.usb()];
        let [chips, laptop, drops] = [self.chips(), self.laptop(), self.drops()];
        let kinds = [settings, rates, ports].into_iter().chain(firmware);
        let kinds = kinds.chain([steps, adapters, usb, chips, laptop, drops]);
        kinds.filter(|kind| !kind.is_empty()).collect()
    }

    fn uart(&self) -> Option<&Uart> {
        if let Link::Uart(uart) = &self.spec.link { Some(uart) } else { None }
    }

    fn latencies(&self) -> Vec<Change> {
        match self.uart().map(|uart| uart.adapter) {
            Some(Adapter::Ftdi(ftdi)) if ftdi.latency_ns > MS => alloc::vec![Change::Latency(MS)],
            _ => Vec::new(),
        }
    }

    fn bauds(&self) -> Vec<Change> {
        let Some(uart) = self.uart() else { return Vec::new() };
        faster(uart).map(Change::Baud).collect()
    }

    fn has_wire(&self) -> bool {
        !matches!(self.spec.link, Link::Ideal | Link::Onboard)
    }

    fn ages(&self) -> Vec<Change> {
        let told = self.spec.firmware.protocol == Protocol::Framed { ages: true };
        if told && self.has_wire() { alloc::vec![Change::NoAges] } else { Vec::new() }
    }

    fn bare(&self) -> Vec<Change> {
        let framed = matches!(self.spec.firmware.protocol, Protocol::Framed { .. });
        if framed && self.has_wire() { alloc::vec![Change::Bare] } else { Vec::new() }
    }

    fn fewer_bits(&self) -> Vec<Change> {
        let any = self.spec.sensors.iter().any(has_many_bits) || has_many_signal_bits(&self.spec);
        let can = !self.spec.firmware.protocol.has_fixed_bits();
        if any && can && self.has_wire() { alloc::vec![Change::FewerBits] } else { Vec::new() }
    }

    /// Of a polled robot: as often as its brain steps, or less. Of a stream: less often. A Khepera speaks only when
    /// asked, and a Create streams at its own pace.
    fn streams(&self) -> Vec<Change> {
        if self.spec.firmware.protocol.is_dialogue() {
            return Vec::new();
        }
        let every = match self.spec.firmware.mode {
            Mode::Poll => self.step_ns,
            Mode::Stream(frame) => frame.period_ns() * 2,
        };
        let periods = [1, 2, 5].map(|times| every * times).into_iter();
        periods.filter(|ns| *ns <= MOST_PERIOD_NS).map(Change::Stream).collect()
    }

    /// Round numbers that are multiples of the present step, so that bodies move as they did.
    fn steps(&self) -> Vec<Change> {
        let rounds =
            [1, 10, 100].into_iter().flat_map(|decade| [1, 2, 3, 4, 5, 6, 8].map(|n| n * decade * MS));
        let longer =
            rounds.filter(|ns| *ns > self.step_ns && ns.is_multiple_of(self.step_ns) && *ns <= SECOND_NS);
        longer.filter(|ns| self.can_step(*ns)).map(Change::Step).collect()
    }

    /// Whether a scenario may have so long a step, in which bodies and rays do what they did in several.
    fn can_step(&self, ns: u64) -> bool {
        let rays = self.spec.sensors.iter().filter_map(|sensor| {
            let period_ns =
                sensor.own_clock.map_or_else(|| sensor.schedule.period_ns(), |clock| clock.period_ns);
            Some(ns.div_ceil(period_ns) * sensor.device.fan()?.len() as u64)
        });
        let substeps = u64::from(self.substeps) * (ns / self.step_ns);
        substeps <= MOST_SUBSTEPS && rays.max().is_none_or(|rays| rays <= MOST_RAYS_A_TICK)
    }

    fn cables(&self) -> Vec<Change> {
        match self.uart().map(|uart| uart.adapter) {
            Some(Adapter::Ftdi(_) | Adapter::Bluetooth(_))
                if self.uart().is_some_and(|u| u.baud <= CDC_MOST) =>
            {
                alloc::vec![Change::Cdc]
            }
            _ => Vec::new(),
        }
    }

    /// USB has no byte errors, and a scenario with a fault that makes some is refused.
    fn usb(&self) -> Vec<Change> {
        let errs = |fault: &Fault| matches!(fault.kind, FaultKind::ByteErrors { .. });
        let can = self.uart().is_some() && !self.spec.faults.iter().any(errs);
        if can && self.is_told_by_silence(Change::Usb) { alloc::vec![Change::Usb] } else { Vec::new() }
    }

    /// Whether the silence that ends a bare message is longer than those within it, if there is one.
    fn is_told_by_silence(&self, change: Change) -> bool {
        let Protocol::Bare { gap_ns } = self.spec.firmware.protocol else { return true };
        gap_ns > self.with(change).spec.link.pause_ns()
    }

    fn chips(&self) -> Vec<Change> {
        let processor = &self.spec.processor;
        let is_slow = |new: &Processor| {
            let per_s = |processor: &Processor| processor.operations_per_s.unwrap_or(0.0);
            per_s(new) > per_s(processor) && new.ram_bytes >= self.spec.brain_memory_bytes
        };
        let mut chips: Vec<_> = presets()
            .filter(|preset| preset.kind == PresetKind::Microcontroller)
            .filter_map(|preset| Some((preset, chip(preset)?)))
            .filter(|(_, new)| is_slow(new) && matters(processor))
            .collect();
        chips.sort_by(|(_, a), (_, b)| {
            a.operations_per_s.partial_cmp(&b.operations_per_s).unwrap_or(core::cmp::Ordering::Equal)
        });
        chips.into_iter().map(|(preset, _)| Change::Chip(preset)).collect()
    }

    fn laptop(&self) -> Vec<Change> {
        if self.spec.is_onboard() { alloc::vec![Change::Laptop] } else { Vec::new() }
    }

    /// The sensor that costs most, on the wire and of the processor.
    fn drops(&self) -> Vec<Change> {
        let wire_ns = self.spec.link.burst_ns(1);
        let cost = |sensor: &Sensor| {
            let bytes = super::plan::sample_bytes(sensor) as u64;
            let device_ns = if sensor.own_clock.is_some() { 0 } else { sensor.device.longest_wait_ns() };
            sensor.acquisition_ns + device_ns + bytes * (wire_ns + self.spec.processor.framing_ns_per_byte)
        };
        let wired = self.spec.sensors.iter().enumerate().filter(|(_, sensor)| sensor.is_on_wire());
        let costliest = wired.max_by_key(|(_, sensor)| cost(sensor)).filter(|(_, sensor)| cost(sensor) > 0);
        costliest.map(|(i, _)| Change::Drop(i)).into_iter().collect()
    }

    /// The effect of a change, in words.
    pub(super) fn phrase(&self, change: Change) -> String {
        let ms = |ns: u64| format!("{} ms", ns as f64 / 1e6);
        let name = |i: usize| self.spec.sensors[i].name.as_str();
        match change {
            Change::Latency(ns) => format!("a latency timer of {}", ms(ns)),
            Change::Baud(baud) => format!("{baud} baud"),
            Change::PortBauds(baud) => self.port_phrase(baud),
            Change::NoAges => "readings without their ages".to_string(),
            Change::Bare => "the bare protocol".to_string(),
            Change::FewerBits => "8 bits a value".to_string(),
            Change::Stream(ns) => format!("a message every {}, without polls", ms(ns)),
            Change::Step(ns) => format!("a step of {}", ms(ns)),
            Change::Cdc => "an adapter without a latency timer".to_string(),
            Change::Usb => "a microcontroller with USB".to_string(),
            Change::Chip(preset) => format!("the processor {}", preset.name),
            Change::Laptop => "a laptop on the robot, at 115200 baud".to_string(),
            Change::Drop(i) => format!("no {}", name(i)),
        }
    }

    /// A change as overrides of the scenario; none if there is no such field.
    pub(super) fn overrides(&self, change: Change) -> Option<Vec<String>> {
        let at = |rest: &str| format!("robots.{}.{rest}", self.spec.table_name());
        let ms = |ns: u64| ns as f64 / 1e6;
        let one = |text: String| Some(alloc::vec![text]);
        match change {
            Change::Latency(ns) => one(at(&format!("link.adapter.latency_ms={}", ms(ns)))),
            Change::Baud(baud) => one(at(&format!("link.baud={baud}"))),
            Change::PortBauds(baud) => Some(self.port_overrides(baud)),
            Change::NoAges => one(at("firmware.ages=false")),
            Change::Bare => {
                let mode = mode_fields(&self.spec).join(", ");
                one(at(&format!("firmware={{ protocol = \"bare\", {mode} }}")))
            }
            Change::Stream(_) => {
                let fields = mode_fields(&self.with(change).spec).into_iter();
                Some(fields.map(|field| at(&format!("firmware.{}", field.replace(" = ", "=")))).collect())
            }
            Change::FewerBits => {
                let sensors = self.spec.sensors.iter().filter(|sensor| has_many_bits(sensor));
                let mut fields: Vec<_> =
                    sensors.map(|sensor| at(&format!("sensors.{}.bits=8", sensor.name))).collect();
                fields.extend(has_many_signal_bits(&self.spec).then(|| at("motors.signal_bits=8")));
                Some(fields)
            }
            Change::Step(ns) => Some(self.step_overrides(ns)),
            Change::Cdc => one(at("link.adapter={ kind = \"cdc\" }")),
            Change::Usb => one(at("link={ kind = \"usb\" }")),
            Change::Chip(preset) => one(at(&format!("microcontroller={{ preset = \"{}\" }}", preset.name))),
            Change::Laptop => Some(alloc::vec![
                at("link={ kind = \"uart\", baud = 115200 }"),
                at(&format!("brain={{ thinking_us = 0{} }}", deadline_fields(&self.spec.deadline))),
            ]),
            Change::Drop(_) => None,
        }
    }

    /// Periods that a file leaves out are those of the step, and are to stay as they are.
    fn step_overrides(&self, step_ns: u64) -> Vec<String> {
        let Self { substeps, .. } = self.with(Change::Step(step_ns));
        let mut fields =
            alloc::vec![format!("step_ms={}", step_ns as f64 / 1e6), format!("substeps={substeps}")];
        let old_ms = self.step_ns as f64 / 1e6;
        let at = |rest: &str| format!("robots.{}.{rest}.period_ms={old_ms}", self.spec.table_name());
        if matches!(self.spec.firmware.mode, Mode::Stream(frame) if frame.period_ns() == self.step_ns) {
            fields.push(at("firmware"));
        }
        let same = |sensor: &&Sensor| sensor.schedule.period_ns() == self.step_ns;
        let sensors = self.spec.sensors.iter().filter(same);
        fields.extend(sensors.map(|sensor| at(&format!("sensors.{}", sensor.name))));
        fields
    }
}

impl Change {
    pub(super) const fn cost(self) -> Cost {
        match self {
            Self::Latency(_) => Cost::Setting,
            Self::Baud(_) | Self::PortBauds(_) => Cost::BothEnds,
            Self::NoAges | Self::Bare | Self::FewerBits | Self::Stream(_) => Cost::Firmware,
            Self::Step(_) => Cost::LongerStep,
            Self::Cdc | Self::Usb => Cost::Cable,
            Self::Chip(_) => Cost::Processor,
            Self::Laptop => Cost::Layout,
            Self::Drop(_) => Cost::Loss,
        }
    }
}

/// Standard rates that are faster than this cable, and that its adapter keeps up with.
pub(super) fn faster(uart: &Uart) -> impl Iterator<Item = u32> {
    let most = match uart.adapter {
        Adapter::None | Adapter::Bluetooth(_) => u32::MAX,
        Adapter::Cdc(_) => CDC_MOST,
        Adapter::Ftdi(ftdi) => {
            let bits = 19 * u64::from(ftdi.packet_bytes) * u64::from(uart.bits_per_character) * SECOND_NS;
            u32::try_from(bits / ftdi.frames.frame_ns).unwrap_or(u32::MAX)
        }
    };
    let now = uart.baud;
    BAUDS.into_iter().filter(move |&baud| baud > now && baud <= most)
}

/// The fields of a scenario for the schedule of a firmware.
fn mode_fields(spec: &RobotModel) -> Vec<String> {
    match spec.firmware.mode {
        Mode::Poll => alloc::vec!["mode = \"poll\"".to_string()],
        Mode::Stream(frame) => {
            // A scenario counts from the start of the firmware.
            let frame = frame.earlier_by(spec.processor.bootloader_ns);
            let [period, phase] = [frame.period_ns(), frame.phase_ns()].map(|ns| ns as f64 / 1e6);
            let [period, phase] = [format!("period_ms = {period}"), format!("phase_ms = {phase}")];
            alloc::vec!["mode = \"stream\"".to_string(), period, phase]
        }
    }
}

/// The deadline that a scenario states, if it does.
fn deadline_fields(deadline: &Deadline) -> String {
    let on_late = match deadline.on_late {
        None => return String::new(),
        Some(OnLate::Hold) => "hold",
        Some(OnLate::Stop) => "stop",
        Some(OnLate::End) => "end",
    };
    format!(", deadline_ms = {}, on_late = \"{on_late}\"", deadline.within_ns as f64 / 1e6)
}

/// Whether a sensor's values could be sent in fewer bits.
pub(super) fn has_many_bits(sensor: &Sensor) -> bool {
    // The largest value of these is unknown, unless there are bits already.
    let unknown = matches!(sensor.device, Device::Field(_) | Device::Microphone(_));
    let many = |encoding: &Encoding| encoding.len() > 1 && !(unknown && *encoding == Encoding::Float64);
    sensor.is_on_wire() && sensor.encodings.iter().any(many)
}

pub(super) fn has_many_signal_bits(spec: &RobotModel) -> bool {
    spec.signal_limit.is_some() && spec.firmware.layout().motors.iter().any(|encoding| encoding.len() > 1)
}

/// Whether another processor could do anything better.
fn matters(processor: &Processor) -> bool {
    let Processor { framing_ns_per_byte, receiving_ns_per_byte, obeying_ns, operations_per_s, .. } =
        *processor;
    operations_per_s.is_some() || framing_ns_per_byte + receiving_ns_per_byte + obeying_ns > 0
}

/// The processor of a preset.
pub(super) fn chip(preset: &Preset) -> Option<Processor> {
    let file: toml::Table = preset.text.parse().ok()?;
    let chip = file.get(preset.kind.word())?.as_table()?;
    let number = |field: &str| {
        chip.get(field).and_then(|value| value.as_float().or_else(|| value.as_integer().map(|n| n as f64)))
    };
    let ns = |field: &str| number(field).map_or(0, |us| (us * 1e3 + 0.5) as u64);
    Some(Processor {
        framing_ns_per_byte: ns("framing_us_per_byte"),
        receiving_ns_per_byte: ns("receiving_us_per_byte"),
        obeying_ns: ns("obeying_us"),
        operations_per_s: number("operations_per_s"),
        ram_bytes: number("ram_bytes").map(|bytes| bytes as u64),
        bootloader_ns: number("bootloader_s").map_or(0, |s| (s * 1e9 + 0.5) as u64),
    })
}

pub(super) const MS: u64 = 1_000_000;

/// The most that a scenario may have: a period, Euler steps in a tick, and rays in a tick.
const MOST_PERIOD_NS: u64 = 10_000_000 * MS;
const MOST_SUBSTEPS: u64 = 10_000;
const MOST_RAYS_A_TICK: u64 = 100_000;

/// 19 packets of 64 bytes a frame of 1 ms, 8 bits a character.
const CDC_MOST: u32 = 9_728_000;

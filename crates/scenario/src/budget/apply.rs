//! A robot with a change.

use alloc::sync::Arc;
use alloc::vec::Vec;

use baudbot_wire::Encoding;

use super::change::{Change, MS, Robot, chip, has_many_bits, has_many_signal_bits};
use crate::presets::Preset;
use baudbot_sim::firmware::{Firmware, Mode, Protocol};
use baudbot_sim::link::{Adapter, Frames, Ftdi, Link, Uart, Usb};
use baudbot_sim::model::RobotModel;
use baudbot_sim::schedule::Schedule;
use baudbot_sim::sensor::Sensor;

impl Robot {
    /// The robot with a change.
    pub(super) fn with(&self, change: Change) -> Self {
        let mut new = self.clone();
        let spec = Arc::make_mut(&mut new.spec.model);
        match change {
            Change::Latency(ns) => set_adapter(&mut spec.link, |old| match old {
                Adapter::Ftdi(ftdi) => Adapter::Ftdi(Ftdi { latency_ns: ns, ..ftdi }),
                other @ (Adapter::None | Adapter::Cdc(_) | Adapter::Bluetooth(_)) => other,
            }),
            Change::Baud(baud) => set_baud(&mut spec.link, baud),
            Change::PortBauds(baud) => {
                let mut sensors = spec.sensors.to_vec();
                let slow = self.slow_ports().into_iter();
                slow.for_each(|(i, _)| set_port_baud(&mut sensors[i], baud));
                spec.sensors = sensors.into();
            }
            Change::NoAges => set_firmware(spec, Protocol::Framed { ages: false }, spec.firmware.mode),
            Change::Bare => set_firmware(spec, Protocol::Bare { gap_ns: 0 }, spec.firmware.mode),
            Change::FewerBits => fewer_bits(spec),
            Change::Stream(period_ns) => {
                set_firmware(spec, spec.firmware.protocol, Mode::Stream(new_schedule(spec, period_ns)));
            }
            Change::Step(step_ns) => {
                new.substeps = new.substeps.saturating_mul((step_ns / new.step_ns) as u32);
                new.step_ns = step_ns;
            }
            Change::Cdc => set_adapter(&mut spec.link, |_| Adapter::Cdc(Frames::of(MS))),
            Change::Usb => spec.link = usb(),
            Change::Chip(preset) => set_chip(spec, preset),
            Change::Laptop => {
                spec.link = cable();
                (spec.thinking_ns, spec.brain_operations, spec.brain_memory_bytes) = (0, None, None);
            }
            Change::Drop(i) => drop_sensor(spec, i),
        }
        new
    }
}

fn set_adapter(link: &mut Link, to: impl Fn(Adapter) -> Adapter) {
    if let Link::Uart(uart) = link {
        uart.adapter = to(uart.adapter);
    }
}

fn set_baud(link: &mut Link, to: u32) {
    if let Link::Uart(uart) = link {
        uart.baud = to;
    }
}

fn set_port_baud(sensor: &mut Sensor, to: u32) {
    if let Some(port) = &mut sensor.port {
        set_baud(&mut port.link, to);
    }
}

fn usb() -> Link {
    Link::Usb(Usb {
        frame_ns: MS,
        bytes_per_frame: 19 * 64,
        laptop_buffer_bytes: 4096,
        outages: Vec::new(),
        cuts: Vec::new(),
    })
}

/// A plain cable: the one of a scenario that states only the rate.
fn cable() -> Link {
    Link::Uart(Uart {
        baud: 115_200,
        bits_per_character: 10,
        receive_depth: 64,
        transmit_depth: 64,
        laptop_buffer_bytes: 4096,
        byte_error_rate: 0.0,
        adapter: Adapter::None,
        turnaround_ns: None,
        outages: Vec::new(),
        cuts: Vec::new(),
        error_bursts: Vec::new(),
    })
}

/// The same sensors and signals in another form, or at another time.
fn set_firmware(spec: &mut RobotModel, protocol: Protocol, mode: Mode) {
    let wired = spec.sensors.iter().filter(|sensor| sensor.is_on_wire());
    let sensors: Vec<_> = wired.map(|sensor| (&*sensor.name, &sensor.encodings[..])).collect();
    spec.firmware = Firmware::new(protocol, mode, &sensors, spec.firmware.layout().motors.to_vec());
}

fn new_schedule(spec: &RobotModel, period_ns: u64) -> Schedule {
    let phase_ns = match spec.firmware.mode {
        Mode::Stream(frame) => frame.phase_ns(),
        Mode::Poll => spec.processor.bootloader_ns,
    };
    Schedule::new(period_ns, phase_ns)
}

fn fewer_bits(spec: &mut RobotModel) {
    let mut sensors = spec.sensors.to_vec();
    for sensor in sensors.iter_mut().filter(|sensor| has_many_bits(sensor)) {
        sensor.encodings.fill(Encoding::Level { bits: 8, min: 0.0, max: 1.0 });
    }
    spec.sensors = sensors.into();
    let mut motors = spec.firmware.layout().motors.to_vec();
    if has_many_signal_bits(spec) {
        motors.fill(Encoding::Signed { bits: 8, limit: 1.0 });
    }
    let wired = spec.sensors.iter().filter(|sensor| sensor.is_on_wire());
    let sensors: Vec<_> = wired.map(|sensor| (&*sensor.name, &sensor.encodings[..])).collect();
    spec.firmware = Firmware::new(spec.firmware.protocol, spec.firmware.mode, &sensors, motors);
}

fn drop_sensor(spec: &mut RobotModel, i: usize) {
    let mut sensors = spec.sensors.to_vec();
    sensors.remove(i);
    spec.sensors = sensors.into();
    set_firmware(spec, spec.firmware.protocol, spec.firmware.mode);
}

fn set_chip(spec: &mut RobotModel, preset: &Preset) {
    let Some(chip) = chip(preset) else { return };
    let thinking_ns = spec.brain_operations.and_then(|operations| chip.thinking_ns(operations));
    spec.thinking_ns = thinking_ns.unwrap_or(spec.thinking_ns);
    start_after(spec, chip.bootloader_ns);
    spec.processor = chip;
}

/// All that is due counts from the start of the firmware, so with another bootloader it is due at other times.
fn start_after(spec: &mut RobotModel, new_ns: u64) {
    let old_ns = spec.processor.bootloader_ns;
    if old_ns == new_ns {
        return;
    }
    let moved = |schedule: Schedule| schedule.earlier_by(old_ns).later_by(new_ns);
    let mut sensors = spec.sensors.to_vec();
    for sensor in sensors.iter_mut().filter(|sensor| sensor.is_on_wire()) {
        sensor.schedule = moved(sensor.schedule);
    }
    spec.sensors = sensors.into();
    if let Mode::Stream(frame) = &mut spec.firmware.mode {
        *frame = moved(*frame);
    }
}

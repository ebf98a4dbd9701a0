//! The way from the raw firmware to the protocol on the robot's cable.

use alloc::format;
use alloc::vec::Vec;
use core::f64::consts::TAU;

use baudbot_wire::codec::Pace;
use baudbot_wire::create::{MOST_STREAMED, STREAM_PERIOD_NS, Version};
use baudbot_wire::{Encoding, asercom, frame, khepera};

use super::{create, raw};
use baudbot_fields::number::{Millis, Number, Rule};
use baudbot_fields::{FieldError, Path};
use baudbot_sim::drive::Drive;
use baudbot_sim::firmware::{Firmware, Mode, Protocol};
use baudbot_sim::link::Link;
use baudbot_sim::motor::Motors;
use baudbot_sim::schedule::Schedule;
use baudbot_sim::sensor::{Device, Sensor};

type Result<T> = core::result::Result<T, FieldError>;

pub(super) fn firmware(
    path: &Path,
    (raw, spoken): (&raw::Firmware, raw::Protocol),
    sensors: &[&Sensor],
    motors: Vec<Encoding>,
    step_ns: u64,
    link: &Link,
) -> Result<Firmware> {
    let no_ages = |name: &str| path.refuse("ages", raw.ages.is_some(), &format!("{name} carries no ages"));
    let problem = "only the bare protocol separates messages by silence";
    let no_gap = || path.refuse("gap_ms", raw.gap_ms.is_some(), problem);
    let protocol = match spoken {
        raw::Protocol::Framed | raw::Protocol::Own => {
            no_gap()?;
            Protocol::Framed { ages: raw.ages.unwrap_or(true) }
        }
        raw::Protocol::Bare => {
            no_ages("the bare protocol")?;
            Protocol::Bare { gap_ns: gap_ns(path, raw.gap_ms, link)? }
        }
        raw::Protocol::Khepera | raw::Protocol::Asercom => {
            no_ages(&format!("the {} protocol", spoken.name()))?;
            no_gap()?;
            can_be_said_in_lines(path, spoken.name(), sensors, &motors)?;
            if spoken == raw::Protocol::Asercom {
                has_16_bits(path, sensors)?;
                Protocol::Asercom
            } else {
                Protocol::Khepera
            }
        }
        raw::Protocol::Create | raw::Protocol::Create2 => {
            no_ages("the Open Interface")?;
            no_gap()?;
            let version = if spoken == raw::Protocol::Create { Version::One } else { Version::Two };
            create::protocol(path, version, sensors, &motors)?
        }
    };
    let mode = mode(path, (raw, spoken.name(), protocol.pace()), step_ns)?;
    let named: Vec<_> = sensors.iter().map(|sensor| (&*sensor.name, sensor.encodings.as_slice())).collect();
    Ok(Firmware::new(protocol, mode, &named, motors))
}

fn mode(path: &Path, (raw, name, pace): (&raw::Firmware, &str, Pace), step_ns: u64) -> Result<Mode> {
    let (is_asked, is_create) = (pace == Pace::Asked, pace == Pace::Opened);
    let usual_ns = if is_create { STREAM_PERIOD_NS } else { step_ns };
    let usual = if is_asked { raw::Mode::Poll } else { raw::Mode::Stream };
    match raw.mode.unwrap_or(usual) {
        raw::Mode::Stream => {
            let problem = format!(
                "must be \"poll\": the {name} protocol answers when asked; to stream, take `protocol` = \"framed\""
            );
            path.refuse("mode", is_asked, &problem)?;
            let period_ns = raw.period_ms.map_or(usual_ns, Number::get);
            Ok(Mode::Stream(Schedule::new(period_ns, raw.phase_ms.map_or(0, Number::get))))
        }
        raw::Mode::Poll => {
            let problem = "must be \"stream\": a Create streams for a brain of messages, and answers one of bytes that asks";
            path.refuse("mode", is_create, problem)?;
            path.refuse("period_ms", raw.period_ms.is_some(), "a polled firmware has no period")?;
            path.refuse("phase_ms", raw.phase_ms.is_some(), "a polled firmware has no phase")?;
            Ok(Mode::Poll)
        }
    }
}

/// A protocol in lines of text has whole numbers, and a command for two wheels.
fn can_be_said_in_lines(path: &Path, name: &str, sensors: &[&Sensor], motors: &[Encoding]) -> Result<()> {
    let path = path.field("protocol");
    let others = motors.len().saturating_sub(2);
    if others > 0 {
        let problem = format!(
            "\"{name}\" has no command for actuators besides the wheels, and there are {others}; take another \
             protocol, or leave them out"
        );
        return Err(path.error(problem));
    }
    let exact = |encodings: &[Encoding]| encodings.contains(&Encoding::Float64);
    if let Some(sensor) = sensors.iter().find(|sensor| exact(&sensor.encodings)) {
        let problem =
            format!("\"{name}\" sends whole numbers; give sensor `{}` a number of `bits`", sensor.name);
        return Err(path.error(problem));
    }
    if exact(motors) {
        let problem = format!("\"{name}\" sends whole numbers; give the motors a number of `signal_bits`");
        return Err(path.error(problem));
    }
    counts_two_wheels(&path, name, sensors)
}

/// The numbers of an e-puck have 16 bits, the sign included.
fn has_16_bits(path: &Path, sensors: &[&Sensor]) -> Result<()> {
    for sensor in sensors {
        let is_too_wide = |encoding: &&Encoding| {
            encoding.numbers().is_some_and(|[_, greatest]| greatest > i64::from(i16::MAX))
        };
        let Some(encoding) = sensor.encodings.iter().find(is_too_wide) else { continue };
        let most = if matches!(encoding, Encoding::Counter { .. }) { 16 } else { 15 };
        let name = &sensor.name;
        let problem =
            format!("\"asercom\" sends numbers of 16 bits; give sensor `{name}` at most {most} `bits`");
        return Err(path.field("protocol").error(problem));
    }
    Ok(())
}

/// The messages of such a protocol have the position counters of the two wheels.
fn counts_two_wheels(path: &Path, name: &str, sensors: &[&Sensor]) -> Result<()> {
    let counts = |sensor: &&&Sensor| {
        sensor.encodings.iter().any(|encoding| matches!(encoding, Encoding::Counter { .. }))
    };
    let counters: Vec<_> = sensors.iter().filter(counts).collect();
    let problem = match counters[..] {
        [] => return Ok(()),
        [one] if khepera::counted(&one.encodings, [0; 2]).is_some() => return Ok(()),
        [one] => {
            format!("\"{name}\" sends the counters of two wheels, and sensor `{}` has others", one.name)
        }
        [one, other, ..] => format!(
            "\"{name}\" sends the counters of one sensor, and there are those of `{}` and `{}`; leave one out",
            one.name, other.name
        ),
    };
    Err(path.error(problem))
}

/// The form of motor signals in `D`: of an e-puck in steps a second; of a Khepera in pulses of its encoders per 10 ms, if it has
/// encoders and its motors regulate the speed. Otherwise, and in other protocols, parts of the full signal.
pub(super) fn speeds(
    protocol: raw::Protocol,
    motor: Encoding,
    drive: &Drive,
    sensors: &[Sensor],
) -> Encoding {
    if protocol == raw::Protocol::Asercom {
        return asercom::SPEED;
    }
    let counts_per_turn = sensors.iter().filter(|sensor| sensor.is_on_wire()).find_map(|sensor| {
        let Device::Encoders(encoders) = &sensor.device else { return None };
        Some(f64::from(encoders.counts_per_turn))
    });
    let (raw::Protocol::Khepera, Encoding::Signed { bits, .. }, Motors::Velocity(velocity), Some(per_turn)) =
        (protocol, motor, &drive.motor, counts_per_turn)
    else {
        return motor;
    };
    let full_per_10ms = velocity.full_speed_m_s / (TAU * drive.wheel_radius_m) * per_turn / 100.0;
    let greatest = ((1_u64 << (bits - 1)) - 1) as f64;
    Encoding::Signed { bits, limit: greatest / full_per_10ms }
}

/// Silence that ends a bare message. The bytes of a message follow each other at the pace of the line, so
/// it must be longer than a character, and than what an adapter can hold one back.
fn gap_ns(path: &Path, gap_ms: Option<Number<raw::Gap>>, link: &Link) -> Result<u64> {
    let (character_ns, pause_ns) = (link.burst_ns(1), link.pause_ns());
    let Some(gap_ms) = gap_ms else {
        return Ok(DEFAULT_GAP_NS.max(4 * character_ns) + (pause_ns - character_ns));
    };
    let gap_ms = gap_ms.get();
    let gap_ns = Millis::<raw::Gap>::value(gap_ms);
    if gap_ns <= pause_ns {
        let what = match pause_ns == character_ns {
            true => "a character on this link",
            false => "the longest pause within a message on this link",
        };
        let problem = format!("must be longer than {what}, {} ms, is {gap_ms}", pause_ns as f64 * 1e-6);
        return Err(path.field("gap_ms").error(problem));
    }
    Ok(gap_ns)
}

const DEFAULT_GAP_NS: u64 = 20_000_000;

/// Whether the messages fit into frames, and into the laptop's driver.
pub(super) fn check_sizes(path: &Path, firmware: &Firmware, link: &Link) -> Result<()> {
    let layout = firmware.layout();
    let readings = layout.readings_len_max();
    let is_handed_over = matches!(link, Link::Onboard) && !firmware.protocol.is_dialogue();
    if is_handed_over {
        return Ok(());
    }
    if readings > frame::MAX_PAYLOAD {
        let limit = frame::MAX_PAYLOAD;
        let problem = format!("a frame of all readings has {readings} bytes, the limit is {limit}");
        return Err(path.field("sensors").error(problem));
    }
    if layout.command_len() > frame::MAX_PAYLOAD {
        let (needed, limit) = (layout.command_len(), frame::MAX_PAYLOAD);
        let problem = format!("a command has {needed} bytes, the limit is {limit}");
        return Err(path.field("actuators").error(problem));
    }
    layout.check().map_err(|error| path.field("sensors").error(format!("{error}")))?;
    let longest = match firmware.protocol.pace() {
        Pace::Any => frame::encoded_len_max(readings.max(layout.command_len())),
        Pace::Asked | Pace::Opened => longest_dialogue(path, firmware)?,
    };
    if link.laptop_buffer() < longest {
        let field = path.field("link").field("laptop_buffer_bytes");
        let problem = format!("must hold the longest message, {longest} bytes, is {}", link.laptop_buffer());
        return Err(field.error(problem));
    }
    Ok(())
}

/// Bytes of the most that is written at once in a dialogue: an answer to a command and a poll, or the two; or what opens a stream,
/// with a command.
fn longest_dialogue(path: &Path, firmware: &Firmware) -> Result<usize> {
    let agreement = firmware.agreement();
    let preface = agreement.preface();
    let readings = agreement.readings_len()[1] + preface.positions[1];
    let (what, limit) = match firmware.protocol.pace() {
        Pace::Opened => ("a message of the stream has", MOST_STREAMED + 3),
        Pace::Any | Pace::Asked => ("lines of all readings have up to", frame::MAX_PAYLOAD),
    };
    if readings > limit {
        let problem = format!("{what} {readings} bytes, the limit is {limit}");
        return Err(path.field("sensors").error(problem));
    }
    let opens = firmware.protocol.is_to_be_opened(0);
    let opening = if opens { agreement.write_poll(&mut 0, &mut [0; frame::MAX_FRAME]) } else { None };
    let command = opening.unwrap_or(0) + agreement.command_len()[1] + agreement.question().len();
    Ok((preface.acknowledgement + readings).max(command))
}

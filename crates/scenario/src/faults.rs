//! A robot's deadline, and what goes wrong on it.

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

use baudbot_fields::number::{Between, Number, Rule, Seconds, Share};
use baudbot_fields::{FieldError, Path};
use baudbot_sim::fault::{Fault, FaultKind, When};
use baudbot_sim::link::Link;
use baudbot_sim::model::{Deadline, OnLate};
use baudbot_sim::random::Stream;
use baudbot_sim::sensor::Sensor;
use baudbot_sim::time::SimTime;

use crate::context::Lasting;

type Result<T> = core::result::Result<T, FieldError>;

/// Most faults of a robot.
const MAX_FAULTS: usize = 64;

baudbot_fields::rules! {
    /// A span of time in which something comes once, in seconds.
    Span: Any, 1e-6, 1e8;
}

/// A fault of a robot.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawFault {
    /// Kind of fault.
    kind: Kind,
    /// Start of the fault. Default: this or `every_s`.
    from_s: Option<Number<Seconds<Between<0, 100_000_000>>>>,
    /// Interval: the fault occurs once in each, at a random time. Default: this or `from_s`.
    every_s: Option<Number<Seconds<Span>>>,
    /// Duration of the fault. Range: at most `every_s`.
    for_s: Number<Seconds<Lasting>>,
    /// Probability that a byte sent during the fault arrives with a wrong bit. The cable's own rate applies if it is
    /// larger. Default: required for `byte-errors`. Range: only `byte-errors`.
    byte_error_rate: Option<Number<Share>>,
    /// Name of the sensor. Default: required for `sensor` and `lost-signal`. Range: only `sensor` and `lost-signal`.
    sensor: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
enum Kind {
    Cable,
    ByteErrors,
    Brain,
    Sensor,
    LostSignal,
}

/// The deadline of a brain: Δt, and nothing follows from it, unless the file states one.
pub(super) fn deadline(
    path: &Path,
    within_ns: Option<u64>,
    on_late: Option<OnLate>,
    step_ns: u64,
) -> Result<Deadline> {
    let path = path.field("brain");
    let Some(within_ns) = within_ns else {
        path.refuse("on_late", on_late.is_some(), "needs a deadline: deadline_ms")?;
        return Ok(Deadline { within_ns: step_ns, on_late: None });
    };
    Ok(Deadline { within_ns, on_late: Some(on_late.unwrap_or_default()) })
}

/// The parts of a robot that faults may concern.
pub(super) struct Parts<'a> {
    pub(super) name: &'a str,
    pub(super) seed: u64,
    pub(super) sensors: &'a [Sensor],
    /// Those that concern the cable are put into it.
    pub(super) link: &'a mut Link,
}

pub(super) fn faults(path: &Path, raw: &[RawFault], mut parts: Parts<'_>) -> Result<Vec<Fault>> {
    let path = path.field("faults");
    if raw.len() > MAX_FAULTS {
        return Err(path.error(format!("there are {}, the limit is {MAX_FAULTS}", raw.len())));
    }
    let mut faults = Vec::new();
    for (i, raw) in raw.iter().enumerate() {
        let path = path.index(i);
        let key = Stream::new(parts.seed, &format!("{}/fault:{i}", parts.name)).key();
        let fault = Fault { when: when(&path, raw, key)?, kind: kind(&path, raw, &parts)? };
        affect(&path, &fault, &mut parts)?;
        faults.push(fault);
    }
    Ok(faults)
}

fn when(path: &Path, raw: &RawFault, key: u64) -> Result<When> {
    let for_ns = raw.for_s.get();
    match (raw.from_s, raw.every_s) {
        (Some(from_s), None) => {
            let from = SimTime::from_ns(from_s.get());
            Ok(When::Once { from, until: from + for_ns })
        }
        (None, Some(every_s)) => {
            let every_ns = every_s.get();
            if for_ns > every_ns {
                let [every_s, for_s] = [every_ns, for_ns].map(Seconds::<Lasting>::written);
                let problem = format!("must not be longer than every_s, which is {every_s}, is {for_s}");
                return Err(path.field("for_s").error(problem));
            }
            Ok(When::Each { every_ns, for_ns, key })
        }
        (None, None) => Err(path
            .field("from_s")
            .error("is missing; give the time: from_s, or every_s for once in each interval")),
        (Some(_), Some(_)) => Err(path.field("every_s").error("give either this or from_s")),
    }
}

fn kind(path: &Path, raw: &RawFault, parts: &Parts<'_>) -> Result<FaultKind> {
    let is = |kind| raw.kind == kind;
    let rate = raw.byte_error_rate;
    let problem = "only for kind = \"byte-errors\"";
    path.refuse("byte_error_rate", rate.is_some() && !is(Kind::ByteErrors), problem)?;
    let no_sensor = !is(Kind::Sensor) && !is(Kind::LostSignal);
    let problem = "only for kind = \"sensor\" or \"lost-signal\"";
    path.refuse("sensor", raw.sensor.is_some() && no_sensor, problem)?;
    match raw.kind {
        Kind::Cable => Ok(FaultKind::Cable),
        Kind::Brain => Ok(FaultKind::Brain),
        Kind::ByteErrors => {
            let missing = || path.field("byte_error_rate").error("is missing: the probability for each byte");
            Ok(FaultKind::ByteErrors { rate: rate.ok_or_else(missing)?.get() })
        }
        Kind::Sensor => {
            let (sensor, name) = sensor(path, raw, parts.sensors, "sticks")?;
            Ok(FaultKind::Sensor { sensor, name })
        }
        Kind::LostSignal => {
            let (sensor, name) = sensor(path, raw, parts.sensors, "gives nothing")?;
            Ok(FaultKind::LostSignal { sensor, name })
        }
    }
}

/// The sensor of which this is the fault: its place and its name.
fn sensor(path: &Path, raw: &RawFault, sensors: &[Sensor], effect: &str) -> Result<(usize, String)> {
    let at = path.field("sensor");
    let missing = || at.error(format!("is missing: the name of the sensor that {effect}"));
    let name = raw.sensor.clone().ok_or_else(missing)?;
    let found = sensors.iter().position(|sensor| sensor.name == name);
    let sensor = found.ok_or_else(|| {
        let names: Vec<_> = sensors.iter().map(|sensor| sensor.name.as_str()).collect();
        let there_are = if names.is_empty() { "none".to_string() } else { names.join(", ") };
        at.error(format!("there is no sensor `{name}`; there are: {there_are}"))
    })?;
    Ok((sensor, name))
}

/// What concerns the cable is put into it.
fn affect(path: &Path, fault: &Fault, parts: &mut Parts<'_>) -> Result<()> {
    let no_cable = || path.field("kind").error("there is no cable; only a uart or a usb link has one");
    match (&fault.kind, &mut *parts.link) {
        (FaultKind::Brain | FaultKind::Sensor { .. } | FaultKind::LostSignal { .. }, _) => {}
        (FaultKind::Cable, Link::Uart(uart)) => uart.cuts.push(fault.when),
        (FaultKind::Cable, Link::Usb(usb)) => usb.cuts.push(fault.when),
        (FaultKind::ByteErrors { rate }, Link::Uart(uart)) => uart.error_bursts.push((fault.when, *rate)),
        (FaultKind::ByteErrors { .. }, Link::Usb(_)) => {
            return Err(path
                .field("kind")
                .error("USB detects and corrects its errors; only a uart has them"));
        }
        (FaultKind::Cable | FaultKind::ByteErrors { .. }, Link::Ideal | Link::Onboard) => {
            return Err(no_cable());
        }
    }
    Ok(())
}

//! Presets in a scenario: `preset = "e-puck"` fills what the table that it stands in leaves out.
//!
//! This happens to the file's table before it is deserialised, after overrides have changed it. So an override can
//! choose a preset, and can change a field of one that the file does not mention: what the file says, overrides
//! included, wins field by field over what the preset says.
//!
//! A table is not filled from a robot's preset if it has a `preset` of its own, which then fills it alone, or if it has
//! another `kind`. Where a file says something in another way than the preset does ([`ALTERNATIVES`]), that way of the
//! preset goes.

use alloc::borrow::ToOwned;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use toml::{Table, Value};

use super::robots::MAX_ROBOTS;
use crate::presets::{self, Preset, PresetKind};
use baudbot_fields::{Cause, FieldError, Path, edits, nearest};

/// Alternative fields: a file that uses one drops the others of the preset.
const ALTERNATIVES: [&[&[&str]]; 4] = [
    &[&["bearing_rad"], &["mount"]],
    &[&["c1_m2", "c2"], &["lookup"], &["ambient_saturation_lux"]],
    &[&["radius_m"], &["outline_m"]],
    &[&["thinking_us"], &["operations"]],
];

/// Words that other fields depend on: a file that changes the word drops those fields of the preset.
const WORDS: [(&str, &[&str]); 2] = [("mode", &["period_ms", "phase_ms"]), ("protocol", &["ages", "gap_ms"])];

/// Tables of a robot that have presets, those of devices apart.
const PARTS: [(&str, PresetKind); 4] = [
    ("motors", PresetKind::Motors),
    ("microcontroller", PresetKind::Microcontroller),
    ("link", PresetKind::Link),
    ("battery", PresetKind::Battery),
];

/// Tables of a robot's devices by name, each of which may have a preset.
const DEVICES: [(&str, PresetKind); 2] =
    [("sensors", PresetKind::Sensor), ("actuators", PresetKind::Actuator)];

/// Most uses of presets in one scenario: each makes more of a file than there is in it.
const MAX_USES: usize = 100_000;

type Result<T> = core::result::Result<T, FieldError>;

/// The presets that a robot is made of: each is filled from the next.
pub(super) type Chain = Vec<&'static Preset>;

/// Replaces each `preset` by its content, and returns for each robot the presets that it was made of.
pub(super) fn expand(table: &mut Table) -> Result<Vec<Chain>> {
    let path = Path::root().field("robots");
    let Some(Value::Array(robots)) = table.get_mut("robots") else { return Ok(Vec::new()) };
    if robots.len() > MAX_ROBOTS {
        return Err(path.error(format!("there are {}, the limit is {MAX_ROBOTS}", robots.len())));
    }
    let mut expander = Expander::default();
    let expand = |(i, robot): (usize, &mut Value)| match robot.as_table_mut() {
        Some(robot) => expander.robot(&path.index(i), robot),
        // The value is no robot, an error of deserialising.
        None => Ok(Chain::new()),
    };
    robots.iter_mut().enumerate().map(expand).collect()
}

/// Presets whose own presets are in place, so that each is parsed once.
#[derive(Default)]
struct Expander {
    done: BTreeMap<&'static str, (Table, Chain)>,
    uses: usize,
}

impl Expander {
    fn robot(&mut self, path: &Path, robot: &mut Table) -> Result<Chain> {
        let mut chain = Chain::new();
        if let Some(preset) = self.take(path, robot, PresetKind::Robot)? {
            let (mut base, rest) = self.resolved(path, preset)?;
            drop_sensors(path, robot, &mut base)?;
            fill_starts(robot, &mut base);
            fill(robot, base);
            chain.push(preset);
            chain.extend(rest);
        } else if robot.contains_key("without") {
            return Err(path
                .field("without")
                .error("lists sensors of a `preset` to leave out, but there is no `preset`"));
        }
        for (part, kind) in PARTS {
            self.part(&path.field(part), robot.get_mut(part), kind)?;
        }
        for (field, kind) in DEVICES {
            let path = path.field(field);
            let Some(Value::Table(devices)) = robot.get_mut(field) else { continue };
            for (name, device) in devices.iter_mut() {
                self.part(&path.field(name), Some(device), kind)?;
            }
            all_have_a_kind(&path, devices, kind.word())?;
        }
        Ok(chain)
    }

    /// A part of a robot; a sensor may have a link of its own, and a link an adapter.
    fn part(&mut self, path: &Path, part: Option<&mut Value>, kind: PresetKind) -> Result<()> {
        let Some(Value::Table(part)) = part else { return Ok(()) };
        if let Some(preset) = self.take(path, part, kind)? {
            fill(part, self.resolved(path, preset)?.0);
        }
        if kind == PresetKind::Sensor
            && let Some(Value::Table(port)) = part.get_mut("port")
        {
            self.part(&path.field("port").field("link"), port.get_mut("link"), PresetKind::Link)?;
        }
        if kind == PresetKind::Link {
            self.part(&path.field("adapter"), part.get_mut("adapter"), PresetKind::Adapter)?;
        }
        Ok(())
    }

    /// Takes out of a table the name of its preset, which must be of this kind.
    fn take(&mut self, path: &Path, table: &mut Table, kind: PresetKind) -> Result<Option<&'static Preset>> {
        let Some(value) = table.remove("preset") else {
            is_not_misspelt(path, table, "preset")?;
            return Ok(None);
        };
        let path = path.field("preset");
        let Value::String(name) = &value else {
            return Err(path.error(format!("must be the name of a preset, is of type {}", value.type_str())));
        };
        self.uses += 1;
        if self.uses > MAX_USES {
            return Err(path.error(format!("presets are used more than {MAX_USES} times")));
        }
        match presets::preset(name) {
            Some(preset) if preset.kind == kind => Ok(Some(preset)),
            Some(preset) => {
                let (is, needed) = (preset.kind.phrase(), kind.phrase());
                Err(path.error(format!("`{name}` is {is}, but {needed} is needed")))
            }
            None => Err(path.error(unknown(name, kind))),
        }
    }

    /// The table of a preset, its own presets in place.
    fn resolved(&mut self, path: &Path, preset: &'static Preset) -> Result<(Table, Chain)> {
        if let Some(done) = self.done.get(preset.name) {
            return Ok(done.clone());
        }
        let mut file: Table = preset.text.parse().map_err(|error| path.error(format!("{error}")))?;
        let mut value = file.remove(preset.kind.word());
        let chain = match &mut value {
            Some(Value::Table(robot)) if preset.kind == PresetKind::Robot => self.robot(path, robot)?,
            part => {
                self.part(path, part.as_mut(), preset.kind)?;
                Chain::new()
            }
        };
        let Some(Value::Table(table)) = value else { return Ok((Table::new(), chain)) };
        self.done.insert(preset.name, (table.clone(), chain.clone()));
        Ok((table, chain))
    }
}

fn unknown(name: &str, kind: PresetKind) -> String {
    let near = presets::nearest(name, Some(kind));
    let near: Vec<_> = near.iter().map(|preset| format!("`{}`", preset.name)).collect();
    let meant = if near.is_empty() { String::new() } else { format!("; did you mean {}?", near.join(", ")) };
    let shortened: String = name.chars().take(80).collect();
    let stop = if meant.is_empty() { ";" } else { "" };
    format!("there is no preset `{shortened}`{meant}{stop} `baudbot preset` lists all")
}

/// Refuses a device of no kind. Its name may be that of another one, misspelt: then it changes nothing, and is a new one.
fn all_have_a_kind(path: &Path, devices: &Table, what: &str) -> Result<()> {
    let is_whole = |device: &Value| device.as_table().is_none_or(|table| table.contains_key("kind"));
    let Some((name, device)) = devices.iter().find(|(_, device)| !is_whole(device)) else { return Ok(()) };
    let path = path.field(name);
    if let Value::Table(table) = device {
        is_not_misspelt(&path, table, "kind")?;
    }
    let others = devices.iter().filter(|(_, device)| is_whole(device)).map(|(name, _)| name);
    let letters: Vec<char> = name.chars().collect();
    let mut meant = nearest(name, others, |name| name).into_iter();
    let problem = match meant.find(|other| edits(&letters, other) <= letters.len().div_ceil(3)) {
        None => "missing field `kind`".to_owned(),
        Some(near) => format!("missing field `kind`, which a new {what} needs; did you mean `{near}`?"),
    };
    Err(path.error(problem).because(Cause::MissingField))
}

/// Refuses a field that is likely to be this one, which the table does not have. Errors of what is parsed later do not know of it.
fn is_not_misspelt(path: &Path, table: &Table, field: &str) -> Result<()> {
    let letters: Vec<char> = field.chars().collect();
    let is_near = |key: &&String| edits(&letters, key) <= letters.len() / 3;
    match table.keys().find(is_near) {
        Some(key) if key != field => {
            let problem = format!("unknown field `{key}`; did you mean `{field}`?");
            Err(path.field(key).error(problem))
        }
        Some(_) | None => Ok(()),
    }
}

/// Takes the sensors that the file does `without` out of the preset.
fn drop_sensors(path: &Path, robot: &mut Table, base: &mut Table) -> Result<()> {
    let Some(without) = robot.remove("without") else { return Ok(()) };
    let path = path.field("without");
    let Value::Array(names) = without else {
        return Err(
            path.error(format!("must be a list of sensors' names, is of type {}", without.type_str()))
        );
    };
    let mut none = Table::new();
    let sensors = base.get_mut("sensors").and_then(Value::as_table_mut).unwrap_or(&mut none);
    let there: Vec<String> = sensors.keys().cloned().collect();
    for (i, name) in names.iter().enumerate() {
        let path = path.index(i);
        let Value::String(name) = name else {
            return Err(path.error(format!("must be the name of a sensor, is of type {}", name.type_str())));
        };
        if !there.contains(name) {
            let shortened: String = name.chars().take(80).collect();
            let problem = match there.join(", ") {
                none if none.is_empty() => {
                    format!("the preset has no sensor `{shortened}`, it has none at all")
                }
                there => format!("the preset has no sensor `{shortened}`; there are: {there}"),
            };
            return Err(path.error(problem));
        }
        sensors.remove(name);
    }
    Ok(())
}

/// The start of a preset is used for each of a robot's `starts`.
fn fill_starts(robot: &mut Table, base: &mut Table) {
    let Some(Value::Array(starts)) = robot.get_mut("starts") else { return };
    let Some(Value::Table(start)) = base.remove("start") else { return };
    starts.iter_mut().filter_map(Value::as_table_mut).for_each(|own| fill(own, start.clone()));
}

/// Puts into a table the fields that it lacks and `base` has, in tables within it as well.
fn fill(table: &mut Table, mut base: Table) {
    if word(table, "preset").is_some() || (word(table, "kind").is_some() && differs(table, &base, "kind")) {
        return;
    }
    for ways in ALTERNATIVES {
        if let Some(used) = ways.iter().position(|way| says(table, way)) {
            let others = ways.iter().enumerate().filter(|(i, _)| *i != used);
            others.flat_map(|(_, way)| way.iter()).for_each(|field| drop(base.remove(*field)));
        }
    }
    for (field, along) in WORDS {
        if word(table, field).is_some() && differs(table, &base, field) {
            along.iter().for_each(|field| drop(base.remove(*field)));
        }
    }
    for (key, value) in base {
        match (table.get_mut(&key), value) {
            (None, value) => drop(table.insert(key, value)),
            (Some(Value::Table(table)), Value::Table(base)) => fill(table, base),
            (Some(_), _) => {}
        }
    }
}

fn says(table: &Table, way: &[&str]) -> bool {
    way.iter().any(|field| table.contains_key(*field))
}

fn word<'a>(table: &'a Table, field: &str) -> Option<&'a str> {
    table.get(field).and_then(Value::as_str)
}

fn differs(table: &Table, base: &Table, field: &str) -> bool {
    word(table, field) != word(base, field)
}

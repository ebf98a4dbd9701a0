//! The robot whose numbers are looked for: of a scenario, or of a preset in a scenario of its own.

use baudbot_fit::Robot;
use baudbot_scenario::presets::{Preset, PresetKind, preset};
use baudbot_scenario::{Override, ScenarioError};
use baudbot_sim::Scenario;

use crate::args::FitArgs;
use crate::error::Refused;
use crate::preset::unknown;
use crate::scenarios::{Source, parse_sets};

/// The robot, and how its fields are written.
pub(super) struct Subject {
    /// The name for titles.
    pub(super) label: String,
    text: String,
    sets: Vec<Override>,
    scenario: Scenario,
    place: usize,
    preset: Option<&'static Preset>,
}

impl Subject {
    pub(super) fn find(args: &FitArgs) -> anyhow::Result<Self> {
        let sets = parse_sets(&args.sets)?;
        match (&args.preset, &args.scenario) {
            (Some(name), _) => Self::of_preset(name, sets),
            (None, Some(file)) => Self::of_scenario(file, args.robot.as_deref(), sets),
            (None, None) => Err(Refused::error("no robot is given; name it with --preset or --scenario")),
        }
    }

    fn of_scenario(file: &str, robot: Option<&str>, sets: Vec<Override>) -> anyhow::Result<Self> {
        let source = Source::find(file)?;
        let scenario = source.parse(&sets)?;
        let names = || scenario.robots.iter().map(|robot| robot.name.as_str()).collect::<Vec<_>>().join(", ");
        let place = match robot {
            Some(name) => scenario.robots.iter().position(|robot| robot.name == name).ok_or_else(|| {
                Refused::error(format!("--robot: there is no robot `{name}`; there are: {}", names()))
            })?,
            None if scenario.robots.len() == 1 => 0,
            None => {
                let names = names();
                return Err(Refused::error(format!(
                    "{file} has several robots; name one with --robot: {names}"
                )));
            }
        };
        Ok(Self { label: file.to_owned(), text: source.into_text(), sets, scenario, place, preset: None })
    }

    fn of_preset(name: &str, sets: Vec<Override>) -> anyhow::Result<Self> {
        let preset = preset(name).ok_or_else(|| Refused::error(format!("--preset: {}", unknown(name))))?;
        let mut last = None;
        // The number of substeps is as large as the body needs.
        for substeps in [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000] {
            let text = scenario_of(preset, substeps);
            match baudbot_scenario::parse_with(&text, &sets) {
                Ok(scenario) => {
                    let label = format!("preset {name}");
                    return Ok(Self { label, text, sets, scenario, place: 0, preset: Some(preset) });
                }
                Err(error) => last = last.or(Some(error)),
            }
        }
        let error = last.map_or_else(String::new, |error| error.to_string());
        Err(Refused::error(format!("--preset {name}: {error}")))
    }

    pub(super) fn robot(&self) -> Robot<'_> {
        let tick_s = self.scenario.step_ns as f64 * 1e-9;
        let substep_s = tick_s / f64::from(self.scenario.substeps);
        Robot { model: &self.scenario.robots[self.place].model, tick_s, substep_s }
    }

    /// The fields of the preset, below the robot, whether or not they can be fitted.
    pub(super) fn others(&self) -> Vec<String> {
        let Some(preset) = self.preset else { return Vec::new() };
        let word = preset.kind.word();
        let below = |path: &str| {
            let rest = path.strip_prefix(word)?.strip_prefix('.')?;
            Some(match preset.kind {
                PresetKind::Robot => rest.to_owned(),
                PresetKind::Sensor => format!("sensors.sensor.{rest}"),
                PresetKind::Actuator => format!("actuators.actuator.{rest}"),
                PresetKind::Adapter => format!("link.adapter.{rest}"),
                PresetKind::Motors | PresetKind::Microcontroller | PresetKind::Link | PresetKind::Battery => {
                    format!("{word}.{rest}")
                }
            })
        };
        preset.facts().iter().filter_map(|fact| below(&fact.path)).collect()
    }

    /// The path of a field and an override that the scenario takes, or why it takes none. Where the scenario has the short
    /// form of a kind of noise, so has the path. What it does not take alone it may take with the `others`, paths and values, that
    /// are found along with it.
    pub(super) fn setting(
        &self,
        path: &str,
        value: &str,
        others: &[(&str, String)],
    ) -> Result<String, ScenarioError> {
        let short = |long: &str, short: &str| path.strip_suffix(long).map(|table| format!("{table}{short}"));
        let shorts = [short("noise.multiplicative", "sigma"), short("noise.additive", "sigma_rad")];
        let try_path = |path: &str| {
            let with_others = others.iter().map(|(other, value)| (*other, value.as_str()));
            let alone = self.try_setting([(path, value)]);
            alone.or_else(|error| self.try_setting(with_others).map_err(|_| error))
        };
        let Err(error) = try_path(path) else { return Ok(path.to_owned()) };
        shorts.into_iter().flatten().find(|path| try_path(path).is_ok()).ok_or(error)
    }

    fn try_setting<'a>(
        &self,
        values: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<(), ScenarioError> {
        let mut sets = self.sets.clone();
        for (path, value) in values {
            let text = format!("{}={value}", self.whole(path));
            sets.push(Override::parse(&text)?);
        }
        baudbot_scenario::parse_with(&self.text, &sets).map(|_| ())
    }

    /// The path of a field in the scenario.
    pub(super) fn whole(&self, path: &str) -> String {
        format!("robots.{}.{path}", self.scenario.robots[self.place].table_name())
    }
}

/// A scenario with a robot of a preset, or with one that has the part.
fn scenario_of(preset: &Preset, substeps: u32) -> String {
    let name = preset.name;
    let part = match preset.kind {
        PresetKind::Robot => {
            return format!(
                "step_ms = 10.0\nsubsteps = {substeps}\n[[robots]]\nname = \"robot\"\npreset = \"{name}\"\n"
            );
        }
        PresetKind::Sensor => format!("sensors.sensor.preset = \"{name}\""),
        PresetKind::Actuator => format!("actuators.actuator.preset = \"{name}\""),
        PresetKind::Adapter => {
            format!("link = {{ kind = \"uart\", baud = 115200, adapter = {{ preset = \"{name}\" }} }}")
        }
        // Motors that are regulated need encoders.
        PresetKind::Motors => {
            format!(
                "motors.preset = \"{name}\"\nsensors.encoders = {{ kind = \"encoders\", counts_per_turn = 1000 }}"
            )
        }
        PresetKind::Microcontroller | PresetKind::Link | PresetKind::Battery => {
            format!("{}.preset = \"{name}\"", preset.kind.word())
        }
    };
    let body = "body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }";
    format!("step_ms = 10.0\nsubsteps = {substeps}\n[[robots]]\nname = \"robot\"\n{body}\n{part}\n")
}

//! `baudbot preset`: what robots and parts there are, and where their numbers are from.

use baudbot_experiment::evidence::known;
use baudbot_scenario::presets::{self, Fact, Preset, PresetKind, presets};
use serde_json::{Value, json};

use crate::args::PresetArgs;
use crate::error::Refused;
use crate::text::{pairs, print, print_json};

pub(crate) fn preset(args: &PresetArgs) -> anyhow::Result<()> {
    let Some(name) = &args.name else {
        return if args.json { print_json(&presets().map(about).collect::<Value>()) } else { print(&list()) };
    };
    let preset = presets::preset(name).ok_or_else(|| Refused::error(unknown(name)))?;
    if args.json {
        print_json(&with_values(preset))
    } else {
        print(&format!("# Known: {}.\n{}", known(preset), preset.text))
    }
}

/// All presets, kind by kind.
fn list() -> String {
    let mut text = String::new();
    for kind in PresetKind::ALL {
        let those = presets().filter(|preset| preset.kind == kind);
        let those: Vec<_> = those.map(|preset| (preset.name, preset.description.to_owned())).collect();
        text += &format!("{}\n{}\n", kind.word(), pairs("  ", &those));
    }
    text.trim_end().to_owned() + "\n"
}

fn about(preset: &'static Preset) -> Value {
    json!({ "name": preset.name, "kind": preset.kind.word(), "description": preset.description })
}

fn with_values(preset: &'static Preset) -> Value {
    let mut about = about(preset);
    about["known"] = known(preset).into();
    about["values"] = preset.facts().iter().map(value).collect();
    about
}

fn value(fact: &Fact) -> Value {
    let source = fact.standing.map(|_| fact.source);
    json!({
        "path": fact.path,
        "value": fact.value,
        "standing": fact.standing.map(|standing| standing.word()),
        "source": source,
    })
}

pub(crate) fn unknown(name: &str) -> String {
    let near = presets::nearest(name, None);
    let near: Vec<_> = near.iter().map(|preset| format!("`{}`", preset.name)).collect();
    match near.join(", ") {
        none if none.is_empty() => format!("there is no preset `{name}`; `baudbot preset` lists all"),
        near => format!("there is no preset `{name}`; did you mean {near}? `baudbot preset` lists all"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_has_every_preset_under_its_kind() {
        let list = list();
        let groups: Vec<_> = list.split("\n\n").collect();
        assert_eq!(groups.len(), PresetKind::ALL.len());
        for (kind, group) in PresetKind::ALL.into_iter().zip(groups) {
            let mut lines = group.lines();
            assert_eq!(lines.next(), Some(kind.word()));
            let names: Vec<_> = lines.map(|line| line.split_whitespace().next().unwrap()).collect();
            let expected: Vec<_> = presets().filter(|p| p.kind == kind).map(|p| p.name).collect();
            assert_eq!(names, expected);
        }
    }
}

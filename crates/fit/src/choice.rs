//! The choice of fields: patterns with `*` over the paths of a robot's fields.
//!
//! A pattern stands for the fields that it matches, and for all below a table that it matches: `sensors.*.noise`.

use baudbot_fields::FieldError;
use baudbot_sim::model::RobotModel;
use wildmatch::WildMatch;

use crate::fields::{Field, catalogue};

/// The fields of a robot that patterns name, in the order of the catalogue. `others` are the paths of fields that the
/// robot has besides, for messages.
///
/// # Errors
/// Names the first pattern that stands for no field that can be fitted, and the fields with the nearest names.
pub fn choose(robot: &RobotModel, patterns: &[String], others: &[String]) -> Result<Vec<Field>, FieldError> {
    let all: Vec<(Field, String)> =
        catalogue(robot).into_iter().map(|field| (field, field.path(robot))).collect();
    let mut wanted = vec![false; all.len()];
    for pattern in patterns {
        let written = usual(pattern);
        let mut found = false;
        for (wanted, (_, path)) in wanted.iter_mut().zip(&all) {
            let fits = matches(&written, path);
            *wanted |= fits;
            found |= fits;
        }
        if !found {
            return Err(unknown(pattern, &written, &all, others));
        }
    }
    Ok(all.into_iter().zip(wanted).filter(|(_, wanted)| *wanted).map(|((field, _), _)| field).collect())
}

/// The pattern with the names that a scenario has: a robot has one link, its motors' noise is not in a table of its own, and
/// `sigma` is short for a kind of noise.
fn usual(pattern: &str) -> String {
    let pattern = pattern.trim();
    let pattern =
        pattern.strip_prefix("links").map_or_else(|| pattern.to_owned(), |rest| format!("link{rest}"));
    let pattern = match pattern.strip_prefix("motors.noise") {
        Some("" | ".*") => "motors.noise_*".to_owned(),
        Some(rest) if rest.starts_with('.') => format!("motors.noise_{}", &rest[1..]),
        Some(_) | None => pattern,
    };
    for (short, long) in [(".sigma", ".noise.multiplicative"), (".sigma_rad", ".noise.additive")] {
        if let Some(sensor) = pattern.strip_suffix(short).filter(|table| table.starts_with("sensors.")) {
            return format!("{sensor}{long}");
        }
    }
    pattern
}

/// Whether a pattern stands for a path, or for a table above it. `*` stands for a part of a path, or for a piece of one.
fn matches(pattern: &str, path: &str) -> bool {
    let (pattern, path): (Vec<&str>, Vec<&str>) = (pattern.split('.').collect(), path.split('.').collect());
    pattern.len() <= path.len()
        && pattern.iter().zip(&path).all(|(pattern, part)| WildMatch::new(pattern).matches(part))
}

fn unknown(pattern: &str, written: &str, all: &[(Field, String)], others: &[String]) -> FieldError {
    let paths = || all.iter().map(|(_, path)| path.as_str());
    if let Some(other) = others.iter().find(|other| matches(written, other)) {
        let problem =
            format!("no model fits `{other}` to a log; `baudbot fit --list` shows what can be fitted");
        return FieldError::new(pattern, problem);
    }
    let near = nearest(written, paths());
    let problem = if near.is_empty() {
        "the robot has no such field that can be fitted; `--list` shows them".to_owned()
    } else {
        let near: Vec<_> = near.iter().map(|path| format!("`{path}`")).collect();
        format!(
            "the robot has no such field that can be fitted; did you mean {}? `--list` shows them",
            near.join(", ")
        )
    };
    FieldError::new(pattern, problem)
}

/// The paths with the fewest edits between, if these are at most a third of it.
fn nearest<'a>(name: &str, paths: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let name: Vec<char> = name.chars().take(LONGEST + 1).collect();
    if name.len() > LONGEST {
        return Vec::new();
    }
    let distances: Vec<_> = paths.map(|path| (baudbot_fields::edits(&name, path), path)).collect();
    let Some(least) = distances.iter().map(|(distance, _)| *distance).min() else { return Vec::new() };
    if least > name.len() / 3 + 1 {
        return Vec::new();
    }
    distances
        .into_iter()
        .filter(|(distance, _)| *distance == least)
        .map(|(_, path)| path)
        .take(MOST_NAMES)
        .collect()
}

/// Longest pattern that is compared, in characters.
const LONGEST: usize = 100;

const MOST_NAMES: usize = 4;

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(patterns: &[&str]) -> Result<Vec<String>, String> {
        let toml =
            "[[robots]]\nname = \"a\"\npreset = \"khepera-1\"\nsensors.ir_0 = { c1_m2 = 5e-4, c2 = 0.0 }\n";
        let scenario = baudbot_scenario::parse(toml).unwrap();
        let robot = &scenario.robots[0];
        let patterns: Vec<String> = patterns.iter().map(ToString::to_string).collect();
        let others = ["body.mass_kg".to_owned()];
        let fields = choose(robot, &patterns, &others).map_err(|error| error.to_string())?;
        Ok(fields.iter().map(|field| field.path(robot)).collect())
    }

    #[test]
    fn patterns_stand_for_fields_and_for_tables() {
        assert_eq!(chosen(&["sensors.ir_0.c1_m2"]).unwrap(), ["sensors.ir_0.c1_m2"]);
        assert_eq!(chosen(&["sensors.*.c2"]).unwrap().len(), 1);
        assert_eq!(chosen(&["sensors.ir_*.noise"]).unwrap().len(), 8 * 5);
        assert_eq!(chosen(&["motors.noise.*"]).unwrap(), ["motors.noise_sigma", "motors.noise_spread"]);
        assert_eq!(chosen(&["body"]).unwrap(), ["body.wheel_radius_m", "body.half_track_m"]);
        assert_eq!(chosen(&["sensors.ir_1.sigma"]).unwrap(), ["sensors.ir_1.noise.multiplicative"]);
        assert_eq!(
            chosen(&["m*s.d*ms", "motors.gain_n_s"]).unwrap(),
            ["motors.dead_time_ms", "motors.gain_n_s"]
        );
    }

    #[test]
    fn what_is_not_there_is_named_with_what_is_near() {
        let error = chosen(&["motors.gain"]).unwrap_err();
        assert_eq!(
            error,
            "motors.gain: the robot has no such field that can be fitted; did you mean `motors.gain_n_s`? `--list` shows them"
        );
        let error = chosen(&["body.mass_kg"]).unwrap_err();
        assert!(error.starts_with("body.mass_kg: no model fits `body.mass_kg` to a log"), "{error}");
        assert!(
            chosen(&["link.*"]).unwrap_err().starts_with("link.*: the robot has no such field"),
            "no adapter"
        );
        assert!(chosen(&[&"x".repeat(1000)]).is_err());
    }
}

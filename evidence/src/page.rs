//! `docs/evidence.md` and its pictures.

use std::fmt::Write as _;

use baudbot_scenario::presets::{Preset, presets};

use crate::comparison::{Compared, Comparison, comparisons};
use crate::experiment::ExperimentError;
use crate::fields::fields;
use crate::guesses::{Guess, SettledBy, guesses};
use crate::known;
use crate::picture::picture;

/// A file of the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// Where it belongs, from the folder `docs`.
    pub path: String,
    /// What is in it.
    pub text: String,
}

/// The page and its pictures. All experiments are done; `done` hears the title of each before it is.
///
/// # Errors
/// If an experiment cannot be done.
pub fn page(mut done: impl FnMut(&Comparison)) -> Result<Vec<File>, ExperimentError> {
    let comparisons = comparisons();
    let (mut files, mut sections, mut contents) = (Vec::new(), String::new(), String::new());
    for comparison in &comparisons {
        done(comparison);
        let points = comparison.run()?;
        let path = format!("pictures/evidence-{}.svg", comparison.name);
        sections += &section(comparison, &points, &path);
        contents += &entry(comparison, &points);
        files.push(File { path, text: picture(comparison, &points) });
    }
    let text = [INTRODUCTION, &contents, &sections, &fields_section(), &known_section(), &guesses_section()]
        .concat();
    files.insert(0, File { path: "evidence.md".into(), text });
    Ok(files)
}

const INTRODUCTION: &str = "\
# Evidence

Presets of real robots, held against what was measured on real robots. This page is made by `baudbot evidence`: each
experiment is done with the preset as it is, in a world as any user has. `./test` makes the page again, and fails if it
differs or if a point disagrees that is not marked so. Points that disagree are red, and say why.

The first table has all comparisons. Behind them come [single numbers](#single-numbers), [how well each preset is
known](#how-well-each-preset-is-known), and the [guesses](#guesses) with what would settle each. The lines of
[`baudbot measure`](how-to/measure.md) and [`baudbot fit`](how-to/fit.md) say how to take and use measurements of your own robot.

| comparison | presets | points that agree |
|---|---|---|
";

fn entry(comparison: &Comparison, points: &[Compared<'_>]) -> String {
    let agree = points.iter().filter(|point| point.agrees).count();
    let mark = if agree == points.len() { "" } else { RED };
    let (title, presets) = (&comparison.title, names(&comparison.presets));
    format!("| [{title}](#{}) | {presets} | {mark}{agree} of {} |\n", anchor(title), points.len())
}

/// What disagrees.
const RED: &str = "🔴 ";

fn section(comparison: &Comparison, points: &[Compared<'_>], picture: &str) -> String {
    let Comparison { title, measured, simulated, source, reliability, x, y, bound, .. } = comparison;
    let mut text = format!(
        "\n## {title}\n\n**Measured.** {} Source: {source} ({}).\n\n**Simulated.** {} A point agrees if {}.\n\n",
        measured.trim(),
        reliability.words(),
        simulated.trim(),
        bound.words()
    );
    let _ =
        write!(text, "![{title}]({picture})\n\n| {x} | measured: {y} | simulated | |\n|---|---|---|---|\n");
    for Compared { measured, simulated, agrees } in points {
        let count = measured.n.map(|n| format!(", n {n}")).unwrap_or_default();
        let spread = measured.sd.map(|sd| format!(" ± {}", short(sd))).unwrap_or_default();
        let range = measured.range.map(|[least, most]| format!(", {} to {}", short(least), short(most)));
        let verdict = match (agrees, &measured.disagrees) {
            (true, None) => "agrees".into(),
            (true, Some(why)) => format!("agrees, although: {why}"),
            (false, why) => format!("{RED}{}", why.as_deref().unwrap_or("disagrees")),
        };
        let _ = writeln!(
            text,
            "| {} | {}{spread}{}{count} | {} ± {}, n {} | {verdict} |",
            measured.at,
            short(measured.mean),
            range.unwrap_or_default(),
            short(simulated.mean),
            short(simulated.sd),
            simulated.n
        );
    }
    text
}

fn fields_section() -> String {
    let mut text = String::from(
        "\n## Single numbers\n\nNumbers of presets, and what is known of the real ones.\n\n\
         | preset | field | value | known | source | |\n|---|---|---|---|---|---|\n",
    );
    for field in fields() {
        let value = field.value().map_or_else(|| "none".into(), |value| value.to_string());
        let verdict = field.disagrees.as_ref().map_or_else(|| "agrees".into(), |why| format!("{RED}{why}"));
        let _ = writeln!(
            text,
            "| `{}` | `{}` | {value} | {} | {} ({}) | {verdict} |",
            field.preset,
            field.path,
            field.measured,
            field.source,
            field.reliability.words()
        );
    }
    text
}

fn known_section() -> String {
    let row = |preset: &Preset| format!("| `{}` | {} |\n", preset.name, known(preset));
    let rows: String = presets().map(row).collect();
    format!("\n## How well each preset is known\n\n| preset | |\n|---|---|\n{rows}")
}

fn guesses_section() -> String {
    let guesses = guesses();
    let mut text = format!(
        "\n## Guesses\n\n{} numbers of presets are guesses. By what would settle them:\n",
        guesses.len()
    );
    for settled_by in SettledBy::ALL {
        let (heading, how) = settled_by.words();
        let row = |guess: &Guess| {
            let fact = &guess.fact;
            format!("| `{}` | `{} = {}` | {} |\n", guess.preset.name, fact.path, fact.value, fact.source)
        };
        let those: Vec<_> = guesses.iter().filter(|guess| guess.settled_by == settled_by).map(row).collect();
        if !those.is_empty() {
            let _ = write!(
                text,
                "\n### {heading}\n\n{how}\n\n| preset | guess | why so |\n|---|---|---|\n{}",
                those.concat()
            );
        }
    }
    text
}

fn names(presets: &[String]) -> String {
    presets.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// A heading's anchor, as GitHub makes it.
fn anchor(title: &str) -> String {
    let kept = title.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

/// A number with four digits that count.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let (mut decimals, mut size) = (3_usize, value.abs());
    while size >= 10.0 && decimals > 0 {
        (decimals, size) = (decimals - 1, size / 10.0);
    }
    while size < 1.0 && decimals < 9 {
        (decimals, size) = (decimals + 1, size * 10.0);
    }
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::{anchor, short};

    #[test]
    fn numbers_have_four_digits() {
        let texts = [0.0, 965.0, 0.9238, 12.3456, 123_456.0, 0.000_123_456].map(short);
        assert_eq!(texts, ["0", "965", "0.9238", "12.35", "123456", "0.0001235"]);
    }

    #[test]
    fn anchors_are_those_of_github() {
        assert_eq!(anchor("Sharp GP2D12 (GP2Y0A21), folds back"), "sharp-gp2d12-gp2y0a21-folds-back");
    }
}

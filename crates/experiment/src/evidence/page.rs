//! `docs/evidence.md` and its pictures.

use std::fmt::Write as _;

use baudbot_scenario::presets::Fact;

use crate::evidence::comparison::{Compared, Comparison, comparisons};
use crate::evidence::experiment::ExperimentError;
use crate::evidence::fields::{Field, fields};
use crate::evidence::guesses::{Guess, SettledBy, guesses};
use crate::evidence::picture::picture;

/// A file of the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct File {
    /// The path of the page, from the folder `docs`.
    pub path: String,
    /// The page's text.
    pub text: String,
}

/// The page and its pictures. All experiments are done; `done` gets the title of each before it is done.
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
    let text = [INTRODUCTION, &contents, &sections, &fields_section(), KNOWN, &guesses_section()].concat();
    files.insert(0, File { path: "evidence.md".into(), text });
    Ok(files)
}

const INTRODUCTION: &str = "\
# Evidence

Presets of real robots compared with measurements of real robots. `baudbot evidence` makes this page: it repeats each
experiment with the preset. `./test slow-tests` makes it again, and fails if it differs or if an unmarked point disagrees. Points
that disagree are red, with the reason. A number was *read* in its source, *computed* from its data, read in an *excerpt*
or a thread, or *recalled* without finding the source. [`baudbot measure`](how-to/measure.md) and [`baudbot fit`](how-to/fit.md) measure
your own robot.

| comparison | presets | points that agree |
|---|---|---|
";

fn entry(comparison: &Comparison, points: &[Compared<'_>]) -> String {
    let agree = points.iter().filter(|point| point.agrees).count();
    let mark = if agree == points.len() { "" } else { RED };
    let (title, presets) = (&comparison.title, names(&comparison.presets));
    format!("| [{title}](#{}) | {presets} | {mark}{agree} of {} |\n", anchor(title), points.len())
}

/// The mark of a point that disagrees.
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
    let heading = |n: Option<usize>| n.map(|n| format!(", n {n}")).unwrap_or_default();
    let (n, simulated_n) =
        (common(points, |point| point.measured.n), common(points, |point| Some(point.simulated.n)));
    let (measured, simulated) = (heading(n), heading(simulated_n));
    let _ = write!(
        text,
        "![{title}]({picture})\n\n| {x} | measured: {y}{measured} | simulated{simulated} | |\n|---|---|---|---|\n"
    );
    points.iter().for_each(|point| text += &row(point, n.is_none(), simulated_n.is_none()));
    text
}

/// The number of values at each point, if that is the same for all and known.
fn common(points: &[Compared<'_>], n: impl Fn(&Compared<'_>) -> Option<usize>) -> Option<usize> {
    let first = n(points.first()?);
    first.filter(|_| points.iter().all(|point| n(point) == first))
}

/// A row of the point; with the number of measurements, where the heading does not have it.
fn row(point: &Compared<'_>, with_n: bool, with_simulated_n: bool) -> String {
    let Compared { measured, simulated, agrees } = point;
    let count = |n: Option<usize>| n.map(|n| format!(", n {n}")).unwrap_or_default();
    let spread = measured.sd.map(|sd| format!(" ± {}", short(sd))).unwrap_or_default();
    let range = measured.range.map(|[least, most]| format!(", {} to {}", short(least), short(most)));
    let verdict = match (agrees, &measured.disagrees) {
        (true, None) => "agrees".into(),
        (true, Some(why)) => format!("agrees, although: {why}"),
        (false, why) => format!("{RED}{}", why.as_deref().unwrap_or("disagrees")),
    };
    format!(
        "| {} | {}{spread}{}{} | {} ± {}{} | {verdict} |\n",
        measured.at,
        short(measured.mean),
        range.unwrap_or_default(),
        count(measured.n.filter(|_| with_n)),
        short(simulated.mean),
        short(simulated.sd),
        count(Some(simulated.n).filter(|_| with_simulated_n)),
    )
}

fn fields_section() -> String {
    let row = |field: &Field| {
        let value = field.value().map_or_else(|| "none".into(), |value| value.to_string());
        let verdict = field.disagrees.as_ref().map_or_else(|| "agrees".into(), |why| format!("{RED}{why}"));
        let (path, known, source) = (&field.path, &field.measured, &field.source);
        format!("`{path}` | {value} | {known} | {source} ({}) | {verdict} |\n", field.reliability.words())
    };
    let rows = gathered(fields().into_iter().map(|field| (row(&field), field.preset)));
    let rows = rows.into_iter().map(|(row, presets)| format!("| {} | {row}", names(&presets)));
    format!(
        "\n## Single numbers\n\nNumbers of presets, and what is known of the real ones.\n\n\
         | preset | field | value | known | source | |\n|---|---|---|---|---|---|\n{}",
        rows.collect::<String>()
    )
}

const KNOWN: &str = "
## How well each preset is known

The [list of presets](reference/preset-list.md) and `baudbot preset NAME` say how many numbers of a preset have a source, and in how many
points it agrees with a real one.
";

fn guesses_section() -> String {
    let guesses = guesses();
    let mut text = format!(
        "\n## Guesses\n\n{} numbers of presets are guesses; `baudbot preset NAME` has all values. By what would settle them:\n",
        guesses.len()
    );
    for settled_by in SettledBy::ALL {
        let (heading, how) = settled_by.words();
        let rows = rows(guesses.iter().filter(|guess| guess.settled_by == settled_by));
        if settled_by == SettledBy::Choice {
            let _ = write!(text, "\n### {heading}\n\n{how}\n");
        } else if !rows.is_empty() {
            let _ = write!(
                text,
                "\n### {heading}\n\n{how}\n\n| preset | guess | why so |\n|---|---|---|\n{rows}"
            );
        }
    }
    text
}

/// A row for each reason of a preset; presets with the same row share it.
fn rows<'a>(guesses: impl Iterator<Item = &'a Guess>) -> String {
    let fact = |Fact { path, value, .. }: &Fact| {
        let is_long = value.is_table() || value.is_array();
        if is_long { format!("`{path}`") } else { format!("`{path} = {value}`") }
    };
    let rows = gathered(guesses.map(|guess| ((guess.preset.name, guess.fact.source), fact(&guess.fact))));
    let rows = rows.into_iter().map(|((preset, why), facts)| ((facts.join(", "), why), preset.to_owned()));
    let row = |((facts, why), presets): ((String, &str), Vec<String>)| {
        format!("| {} | {facts} | {why} |\n", names(&presets))
    };
    gathered(rows).into_iter().map(row).collect()
}

/// The values of each key, in the order in which the keys come first.
fn gathered<K: PartialEq, V>(pairs: impl Iterator<Item = (K, V)>) -> Vec<(K, Vec<V>)> {
    let mut all: Vec<(K, Vec<V>)> = Vec::new();
    for (key, value) in pairs {
        match all.iter_mut().find(|(known, _)| *known == key) {
            Some((_, values)) => values.push(value),
            None => all.push((key, vec![value])),
        }
    }
    all
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
    use super::{anchor, gathered, short};

    #[test]
    fn numbers_have_four_digits() {
        let texts = [0.0, 965.0, 0.9238, 12.3456, 123_456.0, 0.000_123_456].map(short);
        assert_eq!(texts, ["0", "965", "0.9238", "12.35", "123456", "0.0001235"]);
    }

    #[test]
    fn what_has_the_same_key_is_gathered_where_the_key_came_first() {
        let pairs = [("a", 1), ("b", 2), ("a", 3)];
        assert_eq!(gathered(pairs.into_iter()), [("a", vec![1, 3]), ("b", vec![2])]);
    }

    #[test]
    fn anchors_are_those_of_github() {
        assert_eq!(anchor("Sharp GP2D12 (GP2Y0A21), folds back"), "sharp-gp2d12-gp2y0a21-folds-back");
    }
}

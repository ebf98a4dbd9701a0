//! The charts of an experiment: what each shows, and of what. `baudbot_plot` draws them.

use std::collections::BTreeMap;

use baudbot_plot::scale::number;
use baudbot_plot::{caption, chart as plot};

use crate::experiment::Experiment;
use crate::factor::{Choice, Field, Setting};
use crate::figures::INFOS;
use crate::paired::Baseline;
use crate::raw::ChartKind;
use crate::requested_charts::Chart;
use crate::run_record::Row;
use crate::seeds::Seeds;
use crate::statistics::{Sample, wilson};

/// All charts of an experiment, and what they show.
#[derive(Debug)]
pub struct Graphs {
    data: Vec<Data>,
    /// The runs of the first combination, which differences are from.
    first: Baseline,
}

/// The points of a chart, by the places of its two fields' values.
type Data = BTreeMap<(usize, usize), Point>;

/// The results of the runs with the same two values.
#[derive(Clone, Copy, Debug, Default)]
struct Point {
    sample: Sample,
    is_share: bool,
}

impl Graphs {
    /// The charts without any runs.
    pub fn new(experiment: &Experiment) -> Self {
        Self { data: vec![Data::new(); experiment.charts.len()], first: Baseline::default() }
    }

    /// Takes in a row; rows come in the order of their runs.
    pub fn add(&mut self, experiment: &Experiment, row: &Row) {
        let seeds = experiment.seeds.count();
        if row.run < seeds && experiment.charts.iter().any(|chart| chart.is_difference) {
            self.first.add(experiment, row);
        }
        let Ok(ran) = &row.outcome else { return };
        let cell = experiment.task(row.run).cell;
        for (chart, data) in experiment.charts.iter().zip(&mut self.data) {
            let place = |i: usize| place(&experiment.fields[i], &cell.levels[i].name, cell.levels[i].number);
            let key = (place(chart.x), chart.by.map_or(0, place));
            let mut value = match chart.figure {
                Some(figure) => ran.figures.get(figure),
                None => experiment.succeeded(row).map(|success| f64::from(u8::from(success))),
            };
            if chart.is_difference {
                let from = self.first.value((row.run % seeds) as usize, chart.figure);
                value = value.zip(from).map(|(value, from)| value - from);
            }
            let point = data.entry(key).or_default();
            point.is_share = chart.figure.is_none() && !chart.is_difference;
            value.into_iter().for_each(|value| point.sample.add(value));
        }
    }

    /// Names that charts of any experiment can have, but for those with a high number.
    pub(crate) fn names() -> impl Iterator<Item = String> {
        let figures = INFOS.iter().map(|info| info.name).chain(["success"]);
        figures.flat_map(|figure| {
            ["", "-heat", "-difference", "-difference-heat"].into_iter().flat_map(move |kind| {
                let numbers = (2..=9).map(|number| format!("-{number}"));
                [String::new()]
                    .into_iter()
                    .chain(numbers)
                    .map(move |number| format!("{figure}{kind}{number}.svg"))
            })
        })
    }

    /// Each chart as a file's name and its text.
    pub fn draw(&self, experiment: &Experiment) -> Vec<(String, String)> {
        let mut files: Vec<(String, String)> = Vec::new();
        for (chart, data) in experiment.charts.iter().zip(&self.data) {
            let figure = chart.figure.map_or("success", |figure| figure.info().name);
            let difference = if chart.is_difference { "-difference" } else { "" };
            let kind = if chart.kind == ChartKind::Heat { "-heat" } else { "" };
            let stem = format!("{figure}{difference}{kind}");
            let same = files.iter().filter(|(name, _)| is_numbered(name, &stem)).count();
            let number = if same > 0 { format!("-{}", same + 1) } else { String::new() };
            let drawn = drawn(experiment, chart, data);
            let picture = match chart.kind {
                ChartKind::Lines => drawn.lines(),
                ChartKind::Heat => drawn.heat_map(),
            };
            files.push((format!("{stem}{number}.svg"), picture));
        }
        files
    }
}

/// Whether a file's name is this one, with or without a number.
fn is_numbered(name: &str, stem: &str) -> bool {
    let rest = name.strip_prefix(stem).and_then(|rest| rest.strip_suffix(".svg"));
    rest.is_some_and(|rest| {
        rest.is_empty() || rest.strip_prefix('-').is_some_and(|n| n.parse::<u32>().is_ok())
    })
}

impl Point {
    /// The mean or the share, with its interval, if it has one.
    fn value(&self) -> Option<plot::Point> {
        let mean = self.sample.mean()?;
        if self.is_share {
            let successes = (mean * self.sample.count() as f64).round() as u64;
            let (share, low, high) = wilson(successes, self.sample.count())?;
            return Some(plot::Point { value: share, interval: Some((low, high)) });
        }
        let interval = self.sample.half_width().map(|half| (mean - half, mean + half));
        Some(plot::Point { value: mean, interval })
    }
}

/// A chart as it is drawn.
fn drawn(experiment: &Experiment, chart: &Chart, data: &Data) -> plot::Chart {
    let has_bands = chart.kind == ChartKind::Lines && experiment.seeds.count() > 1;
    let note = if has_bands { "; bands: 95 % confidence" } else { "" };
    let range = match chart.figure {
        None if chart.is_difference => plot::Range::Shares,
        None => plot::Range::WholeShares,
        Some(figure) if figure.info().is_share => plot::Range::Shares,
        Some(_) => plot::Range::Numbers,
    };
    plot::Chart {
        title: title(experiment, chart),
        subtitle: subtitle(experiment, chart) + note,
        x: field(&experiment.fields[chart.x]),
        by: chart.by.map(|by| field(&experiment.fields[by])),
        figure: plot::Figure { title: figure_title(chart), range },
        points: data.iter().filter_map(|(&key, point)| Some((key, point.value()?))).collect(),
    }
}

/// The place of a field's value among its levels, or the part of its range.
fn place(field: &Field, name: &str, number: Option<f64>) -> usize {
    match &field.choice {
        Choice::Levels(levels) => levels.iter().position(|level| level.name == name).unwrap_or(0),
        Choice::Range(range) => {
            let share = number.map_or(0.0, |number| range.share(number));
            ((share * BINS as f64) as usize).min(BINS - 1)
        }
    }
}

/// The field of a chart. A range is cut into parts.
fn field(field: &Field) -> plot::Field {
    let values = match &field.choice {
        Choice::Levels(levels) => levels.iter().map(|level| (level.name.clone(), level.number)).collect(),
        Choice::Range(range) => {
            let middle = |i: usize| range.at((i as f64 + 0.5) / BINS as f64);
            (0..BINS).map(|i| (number(middle(i)), Some(middle(i)))).collect()
        }
    };
    plot::Field { label: field.label.clone(), title: field.title(), values }
}

fn figure_title(chart: &Chart) -> String {
    let title = chart.figure.map_or("runs that succeed", |figure| figure.info().title);
    if chart.is_difference { format!("difference of {title}") } else { title.to_owned() }
}

/// The title of a chart.
fn title(experiment: &Experiment, chart: &Chart) -> String {
    let figure = figure_title(chart);
    let by = chart.by.map(|by| format!(" and {}", experiment.fields[by].label)).unwrap_or_default();
    let own = || {
        let words = format!("{figure} by {}{by}", experiment.fields[chart.x].label);
        let mut letters = words.chars();
        letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
    };
    chart.title.clone().unwrap_or_else(own)
}

/// The subject of a chart's numbers.
fn subtitle(experiment: &Experiment, chart: &Chart) -> String {
    let others = (0..experiment.fields.len()).filter(|&i| i != chart.x && Some(i) != chart.by);
    let others: Vec<_> = others.map(|i| experiment.fields[i].label.as_str()).collect();
    let over = if others.is_empty() { String::new() } else { format!(", mean over {}", others.join(", ")) };
    let length = experiment.seconds.map(|seconds| format!(", {} s", number(seconds))).unwrap_or_default();
    let from = if chart.is_difference {
        format!(", from {} with the same seeds", first(experiment))
    } else {
        String::new()
    };
    format!("{}{length}, {}{over}{from}", of_what(experiment), seeds(experiment))
}

/// The values of the first combination.
fn first(experiment: &Experiment) -> String {
    let levels = experiment.cell(0).levels;
    let values = experiment.fields.iter().zip(&levels);
    values.map(|(field, level)| format!("{} {}", field.label, level.name)).collect::<Vec<_>>().join(", ")
}

/// The brains that drove, their scenario, and their links unless those are varied.
pub(crate) fn of_what(experiment: &Experiment) -> String {
    let mut words = format!("{}: {}", experiment.name, experiment.brains.join(", "));
    let Ok(scenario) = baudbot_scenario::parse(&experiment.text) else { return words };
    let name = if scenario.name.is_empty() { &experiment.scenario } else { &scenario.name };
    words += &format!(" in {name}");
    let varied = experiment.fields.iter().any(|field| varies_links(&field.choice));
    let mut links = caption::links(&scenario);
    links.dedup();
    match links.as_slice() {
        [link] if !varied => words + ", " + link,
        _ => words,
    }
}

fn varies_links(choice: &Choice) -> bool {
    let is_of_link = |path: &str| path.contains("link") || path.contains("preset");
    match choice {
        Choice::Range(range) => is_of_link(&range.target),
        Choice::Levels(levels) => {
            levels.iter().flat_map(|level| &level.settings).any(|setting| match setting {
                Setting::Scenario { path, .. } => is_of_link(path),
                Setting::Parameter { .. } | Setting::Brain(_) => false,
            })
        }
    }
}

pub(crate) fn seeds(experiment: &Experiment) -> String {
    match &experiment.seeds {
        Seeds::From(first, last) if first == last => format!("seed {first}"),
        Seeds::From(first, last) => format!("seeds {first} to {last}"),
        Seeds::List(seeds) => format!("{} seeds", seeds.len()),
    }
}

/// Parts that a range is cut into.
const BINS: usize = 12;

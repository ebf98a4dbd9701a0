//! A line for each value of one field over the values of another, with bands of 95 %.

use std::fmt::Write;

use super::axis::{Scale, number, percent};
use super::page::{self, FRAME, Frame, GRID, PALE_INK, line, text, width};
use super::{Data, marks, scale, subtitle, title};
use crate::experiment::{Chart, Experiment};
use crate::svg::{Canvas, Element, px};

/// One line.
struct Line {
    name: String,
    color: &'static str,
    points: Vec<Spot>,
}

/// A point of a line, in the data's numbers.
struct Spot {
    x: f64,
    y: f64,
    band: Option<(f64, f64)>,
    /// What it is, in words.
    words: String,
}

pub(super) fn draw(experiment: &Experiment, chart: &Chart, data: &Data) -> String {
    let field = &experiment.fields[chart.x];
    let marks = marks(field);
    let is_numeric = marks.iter().all(|(_, number)| number.is_some());
    // Values without numbers stand one beside the other.
    let at: Vec<f64> = marks
        .iter()
        .enumerate()
        .map(|(i, (_, number))| number.filter(|_| is_numeric).unwrap_or(i as f64))
        .collect();
    let lines = lines(experiment, chart, data, &at);
    let longest = lines.iter().map(|line| width(&line.name, 12.0)).fold(0.0, f64::max);
    let legend =
        chart.by.map_or(0.0, |by| longest.max(width(&experiment.fields[by].title(), 12.0) - 30.0) + 62.0);
    let frame = Frame { left: 78.0, right: 78.0 + PLOT.0, top: 66.0, bottom: 66.0 + PLOT.1 };
    let size =
        (frame.right + legend.max(24.0), frame.bottom.max(frame.top + 20.0 * lines.len() as f64) + 60.0);
    let is_share = chart.figure.is_none_or(|figure| figure.info().is_share);
    let across = Scale::of(&at, (frame.left, frame.right));
    let up = scale(chart, &heights(&lines), (frame.bottom, frame.top));
    let mut canvas = Canvas::default();
    let note = if experiment.seeds.count() > 1 { "; bands: 95 % confidence" } else { "" };
    page::open(&mut canvas, size, &title(experiment, chart), &(subtitle(experiment, chart) + note));
    let ticks = ticks(&across, &marks, &at, is_numeric);
    grid(&mut canvas, &frame, (&across, &ticks), &up, is_share);
    for line in &lines {
        band(&mut canvas, line, &across, &up);
    }
    for (i, line) in lines.iter().enumerate() {
        stroke(&mut canvas, (i, line), &across, &up);
    }
    let figure = chart.figure.map_or("runs that succeed", |figure| figure.info().title);
    page::names(&mut canvas, &frame, &field.title(), figure);
    if let Some(by) = chart.by {
        self::legend(&mut canvas, &frame, &experiment.fields[by].title(), &lines);
    }
    page::close(canvas)
}

fn lines(experiment: &Experiment, chart: &Chart, data: &Data, at: &[f64]) -> Vec<Line> {
    let names = chart.by.map_or_else(
        || vec![String::new()],
        |by| marks(&experiment.fields[by]).into_iter().map(|(name, _)| page::cut(&name)).collect(),
    );
    let x_name = &experiment.fields[chart.x].label;
    let line = |(i, name): (usize, String)| {
        let spot = |(place, &x): (usize, &f64)| {
            let point = data.get(&(place, i))?;
            let (y, band) = point.value()?;
            let range =
                band.map(|(low, high)| format!(" ({} to {})", number(low), number(high))).unwrap_or_default();
            let words = format!("{name}, {x_name} {}: {}{range}", number(x), number(y));
            Some(Spot { x, y, band, words })
        };
        let points = at.iter().enumerate().filter_map(spot).collect();
        Line { name, color: COLORS[i % COLORS.len()], points }
    };
    let mut lines: Vec<_> = names.into_iter().enumerate().map(line).collect();
    for line in &mut lines {
        line.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    lines
}

fn heights(lines: &[Line]) -> Vec<f64> {
    let spots = || lines.iter().flat_map(|line| &line.points);
    let most = spots().map(|spot| spot.y).fold(0.0, f64::max);
    let ends = spots().flat_map(|spot| spot.band.map_or([spot.y; 2], |(low, high)| [low, high]));
    // What cannot be below nothing is not drawn there, and a band of two seeds does not flatten all others.
    let least = if spots().all(|spot| spot.y >= 0.0) { 0.0 } else { f64::NEG_INFINITY };
    ends.map(|end| end.max(least).min(2.0 * most.max(f64::MIN_POSITIVE))).collect()
}

/// Where the horizontal axis has a tick, and what it says: at the values if there is room for them.
fn ticks(
    across: &Scale,
    marks: &[(String, Option<f64>)],
    at: &[f64],
    is_numeric: bool,
) -> Vec<(f64, String)> {
    let mut own: Vec<_> = at.iter().zip(marks).map(|(&x, (name, _))| (x, page::cut(name))).collect();
    own.sort_by(|a, b| a.0.total_cmp(&b.0));
    let fits = own.windows(2).all(|pair| {
        let room = across.px(pair[1].0) - across.px(pair[0].0);
        room > 0.5 * (width(&pair[0].1, 12.0) + width(&pair[1].1, 12.0)) + 6.0
    });
    if fits || !is_numeric { own } else { across.ticks().into_iter().map(|x| (x, number(x))).collect() }
}

fn grid(
    canvas: &mut Canvas,
    frame: &Frame,
    (across, ticks): (&Scale, &[(f64, String)]),
    up: &Scale,
    is_share: bool,
) {
    for (x, words) in ticks {
        let x = across.px(*x);
        canvas.put(line((x, frame.top), (x, frame.bottom), GRID));
        canvas.put(line((x, frame.bottom), (x, frame.bottom + 5.0), FRAME));
        canvas.put(text((x, frame.bottom + 20.0), "middle", words).set("fill", PALE_INK));
    }
    for tick in up.ticks() {
        let y = up.px(tick);
        canvas.put(line((frame.left, y), (frame.right, y), GRID));
        let words = if is_share { percent(tick) } else { number(tick) };
        canvas.put(text((frame.left - 8.0, y + 4.0), "end", &words).set("fill", PALE_INK));
    }
    canvas.put(line((frame.left, frame.bottom), (frame.right, frame.bottom), FRAME));
}

fn band(canvas: &mut Canvas, line: &Line, across: &Scale, up: &Scale) {
    let edge = |spot: &Spot, high: bool| {
        spot.band.map(|(low, top)| {
            format!("{} {} ", px(across.px(spot.x)), px(up.px(if high { top } else { low })))
        })
    };
    let forth: Vec<_> = line.points.iter().filter_map(|spot| edge(spot, true)).collect();
    let back: Vec<_> = line.points.iter().rev().filter_map(|spot| edge(spot, false)).collect();
    if forth.len() > 1 {
        let points = forth.concat() + &back.concat();
        canvas.put(
            Element::new("polygon")
                .set("points", points.trim_end())
                .set("fill", line.color)
                .set("opacity", "0.14"),
        );
    } else if let Some((low, high)) = line.points.iter().find_map(|spot| spot.band) {
        let x = across.px(line.points[0].x);
        canvas.put(page::line((x, up.px(low)), (x, up.px(high)), line.color));
    }
}

fn stroke(canvas: &mut Canvas, (i, line): (usize, &Line), across: &Scale, up: &Scale) {
    let mut data = String::new();
    for (j, spot) in line.points.iter().enumerate() {
        let letter = if j == 0 { 'M' } else { 'L' };
        let _ = write!(data, "{letter}{} {}", px(across.px(spot.x)), px(up.px(spot.y)));
    }
    let path = Element::new("path").set("d", &data).set("fill", "none").set("stroke", line.color);
    canvas.put(path.set("stroke-width", "2").set("stroke-linejoin", "round"));
    for spot in &line.points {
        canvas.put(marker(i, (across.px(spot.x), up.px(spot.y)), line.color).titled(&spot.words));
    }
}

/// A mark of another form for each line, for those who see no colours.
fn marker(i: usize, (x, y): (f64, f64), color: &str) -> Element {
    let corners: &[(f64, f64)] = match i % 4 {
        1 => &[(-3.6, -3.6), (3.6, -3.6), (3.6, 3.6), (-3.6, 3.6)],
        2 => &[(0.0, -4.8), (4.6, 3.6), (-4.6, 3.6)],
        3 => &[(0.0, -5.0), (5.0, 0.0), (0.0, 5.0), (-5.0, 0.0)],
        _ => {
            let circle = Element::new("circle").number("cx", x).number("cy", y).number("r", 4.0);
            return circle.set("fill", color).set("stroke", page::PAPER);
        }
    };
    let points: Vec<_> = corners.iter().map(|(dx, dy)| format!("{} {}", px(x + dx), px(y + dy))).collect();
    Element::new("polygon").set("points", &points.join(" ")).set("fill", color).set("stroke", page::PAPER)
}

fn legend(canvas: &mut Canvas, frame: &Frame, title: &str, lines: &[Line]) {
    let left = frame.right + 18.0;
    canvas.put(text((left, frame.top + 10.0), "start", title).set("font-weight", "600"));
    for (i, line) in lines.iter().enumerate() {
        let y = frame.top + 32.0 + 20.0 * i as f64;
        canvas.put(page::line((left, y), (left + 22.0, y), line.color).set("stroke-width", "2"));
        canvas.put(marker(i, (left + 11.0, y), line.color));
        canvas.put(text((left + 30.0, y + 4.0), "start", &line.name));
    }
}

/// Of Okabe's and Ito's set, which the colour-blind tell apart.
pub(super) const COLORS: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b58900", "#56b4e9", "#4d4d4d"];

/// Size of the plot, in pixels.
const PLOT: (f64, f64) = (560.0, 330.0);

//! A line for each value of one field over the values of another, with bands of 95 %.

use super::page::{self, Frame, line, marker, text, width};
use super::{Chart, Field, Figure, Point};
use crate::palette::{FRAME, GRID, PALE_INK, SERIES};
use crate::scale::{Scale, number};
use crate::svg::{Canvas, Element, drawn, path, px};

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
    /// The tooltip of the spot.
    words: String,
}

pub(super) fn draw(chart: &Chart) -> String {
    let is_numeric = chart.x.is_numeric();
    // Values without numbers stand one beside the other.
    let place =
        |(i, (_, number)): (usize, &(String, Option<f64>))| number.filter(|_| is_numeric).unwrap_or(i as f64);
    let at: Vec<f64> = chart.x.values.iter().enumerate().map(place).collect();
    let lines = lines(chart, &at);
    let longest = lines.iter().map(|line| width(&line.name, 12.0)).fold(0.0, f64::max);
    let by = chart.by.as_ref();
    let legend = by.map_or(0.0, |by| longest.max(width(&by.title, 12.0) - 30.0) + 62.0);
    let frame = Frame { left: 78.0, right: 78.0 + PLOT.0, top: 66.0, bottom: 66.0 + PLOT.1 };
    let size =
        (frame.right + legend.max(24.0), frame.bottom.max(frame.top + 20.0 * lines.len() as f64) + 60.0);
    let across = Scale::of(&at, (frame.left, frame.right));
    let up = chart.figure.scale(&heights(&lines), (frame.bottom, frame.top));
    let mut canvas = Canvas::default();
    page::open(&mut canvas, size, &chart.title, &chart.subtitle);
    let ticks = ticks(&across, &chart.x, &at);
    grid(&mut canvas, &frame, (&across, &ticks), (&up, &chart.figure));
    for line in &lines {
        band(&mut canvas, line, &across, &up);
    }
    for (i, line) in lines.iter().enumerate() {
        stroke(&mut canvas, (i, line), &across, &up);
    }
    page::names(&mut canvas, &frame, &chart.x.title, &chart.figure.title);
    if let Some(by) = by {
        self::legend(&mut canvas, &frame, &by.title, &lines);
    }
    page::close(canvas)
}

fn lines(chart: &Chart, at: &[f64]) -> Vec<Line> {
    let names = chart.by.as_ref().map_or_else(
        || vec![String::new()],
        |by| by.values.iter().map(|(name, _)| page::cut(name)).collect(),
    );
    let x_name = &chart.x.label;
    let line = |(i, name): (usize, String)| {
        let spot = |(place, &x): (usize, &f64)| {
            let &Point { value: y, interval: band } = chart.points.get(&(place, i))?;
            let range =
                band.map(|(low, high)| format!(" ({} to {})", number(low), number(high))).unwrap_or_default();
            let words = format!("{name}, {x_name} {}: {}{range}", number(x), number(y));
            Some(Spot { x, y, band, words })
        };
        let points = at.iter().enumerate().filter_map(spot).collect();
        Line { name, color: SERIES[i % SERIES.len()], points }
    };
    let mut lines: Vec<_> = names.into_iter().enumerate().map(line).collect();
    for line in &mut lines {
        line.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    lines
}

fn heights(lines: &[Line]) -> Vec<f64> {
    let spots = || lines.iter().flat_map(|line| &line.points);
    let most = spots().map(|spot| spot.y.abs()).fold(0.0, f64::max);
    let ends = spots().flat_map(|spot| spot.band.map_or([spot.y; 2], |(low, high)| [low, high]));
    // A quantity that cannot be negative has no negative part of the axis, and a band of two seeds does not flatten
    // all others.
    let least = if spots().all(|spot| spot.y >= 0.0) { 0.0 } else { f64::NEG_INFINITY };
    let most = 2.0 * most.max(f64::MIN_POSITIVE);
    ends.map(|end| end.max(least).clamp(-most, most)).collect()
}

/// The ticks of the horizontal axis and their labels: at the values, if there is room for them.
fn ticks(across: &Scale, field: &Field, at: &[f64]) -> Vec<(f64, String)> {
    let mut own: Vec<_> = at.iter().zip(&field.values).map(|(&x, (name, _))| (x, page::cut(name))).collect();
    own.sort_by(|a, b| a.0.total_cmp(&b.0));
    let fits = own.windows(2).all(|pair| {
        let room = across.px(pair[1].0) - across.px(pair[0].0);
        room > 0.5 * (width(&pair[0].1, 12.0) + width(&pair[1].1, 12.0)) + 6.0
    });
    if fits || !field.is_numeric() {
        own
    } else {
        across.ticks().into_iter().map(|x| (x, number(x))).collect()
    }
}

fn grid(
    canvas: &mut Canvas,
    frame: &Frame,
    (across, ticks): (&Scale, &[(f64, String)]),
    (up, figure): (&Scale, &Figure),
) {
    for (x, words) in ticks {
        let x = across.px(*x);
        canvas.put(line((x, frame.top), (x, frame.bottom), GRID));
        canvas.put(line((x, frame.bottom), (x, frame.bottom + 5.0), FRAME));
        canvas.put(text((x, frame.bottom + 20.0), "middle", words).set("fill", PALE_INK));
    }
    for tick in up.ticks() {
        let y = up.px(tick);
        let is_zero = tick == 0.0 && y < frame.bottom;
        canvas.put(line((frame.left, y), (frame.right, y), if is_zero { FRAME } else { GRID }));
        canvas.put(text((frame.left - 8.0, y + 4.0), "end", &figure.words(tick)).set("fill", PALE_INK));
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
    let data = path(line.points.iter().map(|spot| (across.px(spot.x), up.px(spot.y))));
    let stroke = drawn(&data).set("fill", "none").set("stroke", line.color);
    canvas.put(stroke.set("stroke-width", "2").set("stroke-linejoin", "round"));
    for spot in &line.points {
        canvas.put(marker(i, (across.px(spot.x), up.px(spot.y)), line.color).titled(&spot.words));
    }
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

/// Size of the plot, in pixels.
const PLOT: (f64, f64) = (560.0, 330.0);

//! The progress of a tuning: the scores of its candidates, the best so far, and the numbers of the best.

use super::page::{self, Frame, line, text, width};
use crate::palette::{FRAME, GRID, PALE_INK, SERIES};
use crate::scale::{Scale, number, percent};
use crate::svg::{Canvas, Element, drawn, px};

/// The progress of a tuning. Generations count from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// The first line.
    pub title: String,
    /// The line below it.
    pub subtitle: String,
    /// The quantity that is maximized.
    pub goal: String,
    /// The last generation.
    pub generations: f64,
    /// The score without tuning.
    pub untuned: Option<f64>,
    /// The generation and the score of each candidate, and its tooltip.
    pub scores: Vec<(f64, f64, String)>,
    /// Generations with a new best candidate, and its score.
    pub best: Vec<(f64, f64)>,
    /// The numbers of the best candidate, as shares of their ranges: labels, and generations with new values.
    pub numbers: Vec<(String, Vec<(f64, f64)>)>,
}

/// The picture as SVG.
pub fn draw(progress: &Progress) -> String {
    let names = progress.numbers.iter().map(|(label, _)| width(&page::cut(label), 12.0));
    let right = LEFT + WIDTH;
    let legend = names.fold(width("untuned", 12.0), f64::max) + 62.0;
    let scores = Frame { left: LEFT, right, top: 66.0, bottom: 66.0 + SCORES };
    let numbers =
        Frame { left: LEFT, right, top: scores.bottom + 40.0, bottom: scores.bottom + 40.0 + NUMBERS };
    let needed = numbers.top + 10.0 + 20.0 * progress.numbers.len() as f64;
    let mut canvas = Canvas::default();
    let size = (right + legend, numbers.bottom.max(needed) + 60.0);
    page::open(&mut canvas, size, &progress.title, &progress.subtitle);
    let across = Scale::between(1.0, progress.generations.max(2.0), (LEFT, right));
    draw_scores(&mut canvas, &scores, &across, progress);
    draw_numbers(&mut canvas, &numbers, &across, progress);
    page::close(canvas)
}

fn draw_scores(canvas: &mut Canvas, frame: &Frame, across: &Scale, progress: &Progress) {
    let all: Vec<f64> = progress.scores.iter().map(|(_, score, _)| *score).chain(progress.untuned).collect();
    let up = Scale::of(&all, (frame.bottom, frame.top));
    grid(canvas, frame, across, &up, number);
    let dots = progress.scores.iter().map(|(generation, score, words)| {
        let dot = Element::new("circle").number("cx", across.px(*generation)).number("cy", up.px(*score));
        dot.number("r", 2.5).set("fill", FRAME).set("opacity", "0.7").titled(words)
    });
    dots.for_each(|dot| canvas.put(dot));
    if let Some(untuned) = progress.untuned {
        let y = up.px(untuned);
        canvas.put(line((frame.left, y), (frame.right, y), UNTUNED).set("stroke-dasharray", "6 4"));
        canvas.put(text((frame.right + 18.0, y + 4.0), "start", "untuned").set("fill", UNTUNED));
    }
    canvas
        .put(steps(&progress.best, progress.generations, (across, &up), SERIES[0]).set("stroke-width", "2"));
    if let Some((_, best)) = progress.best.last() {
        canvas.put(text((frame.right + 18.0, up.px(*best) + 4.0), "start", "best").set("fill", SERIES[0]));
    }
    page::names(canvas, frame, "", &page::cut(&progress.goal));
}

fn draw_numbers(canvas: &mut Canvas, frame: &Frame, across: &Scale, progress: &Progress) {
    let up = Scale::share((frame.bottom, frame.top));
    grid(canvas, frame, across, &up, percent);
    for (i, (label, points)) in progress.numbers.iter().enumerate() {
        let color = SERIES[i % SERIES.len()];
        let dashes = DASHES[(i / SERIES.len()) % DASHES.len()];
        let path = steps(points, progress.generations, (across, &up), color);
        canvas.put(path.set("stroke-width", "1.5").set("stroke-dasharray", dashes));
        let (left, y) = (frame.right + 18.0, frame.top + 10.0 + 20.0 * i as f64);
        canvas.put(line((left, y - 4.0), (left + 22.0, y - 4.0), color).set("stroke-dasharray", dashes));
        canvas.put(text((left + 30.0, y), "start", &page::cut(label)));
    }
    page::names(canvas, frame, "generation", "of the range");
}

/// A line of steps, which stays at the last point until the end.
fn steps(points: &[(f64, f64)], end: f64, (across, up): (&Scale, &Scale), color: &str) -> Element {
    let mut data = String::new();
    for (i, (x, y)) in points.iter().enumerate() {
        let (x, y) = (px(across.px(*x)), px(up.px(*y)));
        data += &if i == 0 { format!("M{x} {y}") } else { format!("H{x}V{y}") };
    }
    if !points.is_empty() {
        data += &format!("H{}", px(across.px(end)));
    }
    drawn(&data).set("fill", "none").set("stroke", color)
}

fn grid(canvas: &mut Canvas, frame: &Frame, across: &Scale, up: &Scale, words: fn(f64) -> String) {
    for tick in across.ticks().into_iter().filter(|tick| tick.fract() == 0.0) {
        let x = across.px(tick);
        canvas.put(line((x, frame.top), (x, frame.bottom), GRID));
        canvas.put(text((x, frame.bottom + 18.0), "middle", &number(tick)).set("fill", PALE_INK));
    }
    for tick in up.ticks() {
        let y = up.px(tick);
        canvas.put(line((frame.left, y), (frame.right, y), GRID));
        canvas.put(text((frame.left - 8.0, y + 4.0), "end", &words(tick)).set("fill", PALE_INK));
    }
    canvas.put(line((frame.left, frame.bottom), (frame.right, frame.bottom), FRAME));
}

const LEFT: f64 = 84.0;
const WIDTH: f64 = 560.0;
const SCORES: f64 = 240.0;
const NUMBERS: f64 = 180.0;
const UNTUNED: &str = "#9a3412";
/// The dashes, as colours repeat from the eighth number on.
const DASHES: [&str; 3] = ["none", "6 3", "2 3"];

//! Heat maps: a colour for each pair of two fields' values.

use super::page::{self, Frame, line, text, width};
use super::{Chart, Field, Figure};
use crate::palette::{FRAME, INK, PALE_INK, WHITE, css};
use crate::scale::Scale;
use crate::svg::{Canvas, Element};

pub(super) fn draw(chart: &Chart, by: &Field) -> String {
    let columns = names(&chart.x);
    let rows = names(by);
    let values: Vec<f64> = chart.points.values().map(|point| point.value).collect();
    let (frame, cell) = frame(&columns, &rows);
    let size = ((frame.right + 110.0).max(width(&chart.title, 16.0) + 40.0), frame.bottom + 60.0);
    let up = (frame.bottom, frame.top);
    let scale = chart.figure.scale(&values, up);
    let mut canvas = Canvas::default();
    page::open(&mut canvas, size, &chart.title, &chart.subtitle);
    for (i, column) in columns.iter().enumerate() {
        let x = frame.left + (i as f64 + 0.5) * cell.0;
        canvas.put(text((x, frame.bottom + 18.0), "middle", column).set("fill", PALE_INK));
    }
    for (j, row) in rows.iter().enumerate() {
        // Numbers grow upwards, names are read downwards.
        let from_top = if by.is_numeric() { rows.len() - 1 - j } else { j };
        let y = frame.top + from_top as f64 * cell.1;
        canvas.put(text((frame.left - 8.0, y + 0.5 * cell.1 + 4.0), "end", row).set("fill", PALE_INK));
        for i in 0..columns.len() {
            let value = chart.points.get(&(i, j)).map(|point| point.value);
            let share = value.map(|value| (up.0 - scale.px(value)) / (up.0 - up.1));
            let place = (frame.left + i as f64 * cell.0, y);
            tile(
                &mut canvas,
                (place, cell),
                share,
                &value.map_or_else(|| "—".to_owned(), |value| chart.figure.words(value)),
            );
        }
    }
    page::names(&mut canvas, &frame, &chart.x.title, &by.title);
    key(&mut canvas, &frame, &scale, &chart.figure);
    page::close(canvas)
}

/// The frame of the cells, and the size of a cell.
fn frame(columns: &[String], rows: &[String]) -> (Frame, (f64, f64)) {
    let longest = rows.iter().map(|name| width(name, 12.0)).fold(0.0, f64::max);
    let (left, across) = (50.0 + longest.max(20.0), cell_width(columns));
    let height = (38.0 * rows.len() as f64).max(LEAST_HEIGHT);
    let right = left + across * columns.len() as f64;
    let frame = Frame { left, right, top: 66.0, bottom: 66.0 + height };
    (frame, (across, height / rows.len().max(1) as f64))
}

fn names(field: &Field) -> Vec<String> {
    field.values.iter().map(|(name, _)| page::cut(name)).collect()
}

fn cell_width(columns: &[String]) -> f64 {
    let longest = columns.iter().map(|name| width(name, 12.0)).fold(0.0, f64::max);
    (longest + 14.0).max(58.0).max((LEAST_WIDTH / columns.len().max(1) as f64).min(110.0))
}

/// A cell with its value.
fn tile(canvas: &mut Canvas, ((x, y), (w, h)): ((f64, f64), (f64, f64)), share: Option<f64>, words: &str) {
    let rect = Element::new("rect").number("x", x + 1.0).number("y", y + 1.0);
    let rect = rect.number("width", w - 2.0).number("height", h - 2.0).number("rx", 2.0);
    let (fill, ink) = match share {
        Some(share) => (color(share), if share > 0.5 { WHITE } else { INK }),
        None => ("#e3e5e9".to_owned(), PALE_INK),
    };
    canvas.put(rect.set("fill", &fill));
    canvas
        .put(text((x + 0.5 * w, y + 0.5 * h + 4.5), "middle", words).set("fill", ink).set("font-size", "13"));
}

/// The scale of colours, on the right.
fn key(canvas: &mut Canvas, frame: &Frame, scale: &Scale, figure: &Figure) {
    let (left, steps) = (frame.right + 22.0, 40);
    let height = (frame.bottom - frame.top) / f64::from(steps);
    for i in 0..steps {
        let share = (f64::from(i) + 0.5) / f64::from(steps);
        let y = frame.bottom - f64::from(i + 1) * height;
        let rect = Element::new("rect").number("x", left).number("y", y).number("width", 14.0);
        // A little overlap, so that no gaps are seen between them.
        canvas.put(rect.number("height", height + 0.4).set("fill", &color(share)));
    }
    for tick in scale.ticks() {
        let y = scale.px(tick);
        canvas.put(line((left + 14.0, y), (left + 18.0, y), FRAME));
        canvas.put(text((left + 22.0, y + 4.0), "start", &figure.words(tick)).set("fill", PALE_INK));
    }
    canvas.put(
        text((left + 14.0, frame.top - 8.0), "end", &page::cut(&figure.title))
            .set("fill", PALE_INK)
            .set("font-size", "11"),
    );
}

/// The colours go from pale to dark blue: lightness alone is the value.
fn color(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let i = (at as usize).min(STOPS.len() - 2);
    let mix = |channel: usize| {
        let (a, b) = (f64::from(STOPS[i][channel]), f64::from(STOPS[i + 1][channel]));
        (a + (b - a) * (at - i as f64)).round() as u8
    };
    css([mix(0), mix(1), mix(2)])
}

/// Brewer's Blues, without its palest.
const STOPS: [[u8; 3]; 5] =
    [[0xe4, 0xee, 0xf8], [0xae, 0xcd, 0xe8], [0x5f, 0xa2, 0xd0], [0x21, 0x6f, 0xb4], [0x08, 0x30, 0x6b]];

/// The least width and height of all cells, in pixels.
const LEAST_WIDTH: f64 = 420.0;
const LEAST_HEIGHT: f64 = 150.0;

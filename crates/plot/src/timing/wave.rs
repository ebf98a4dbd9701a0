//! The signal of a wire: high, low, undriven, driven against each other, or pulses that are too short to be drawn one by one.

use std::fmt::Write;

use baudbot_sim::chip::{Level, Pulses, Stretch};

use super::axis::Axis;
use super::bars::SIZE;
use super::diagram::{ROW, rectangle};
use super::lanes::handy_ms;
use super::pins::pulses_in_words;
use crate::palette::{FRAME, INK, LATE, ROBOT, WHITE};
use crate::svg::{Canvas, Element, px, text};
use crate::text::width;

/// The appearance of a part of a signal, in the order of the key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Look {
    /// High or low.
    Driven,
    /// The wire is not driven.
    Open,
    /// The wire is driven by two outputs against each other.
    Short,
    /// Pulses.
    Pulses,
}

impl Look {
    fn of(stretch: &Stretch) -> Self {
        match stretch {
            Stretch::Level { level: Level::Low | Level::High, .. } => Self::Driven,
            Stretch::Level { level: Level::Open, .. } => Self::Open,
            Stretch::Level { level: Level::Short, .. } => Self::Short,
            Stretch::Pulses(_) => Self::Pulses,
        }
    }

    /// The words in the key.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Driven => "high, low",
            Self::Open => "not driven, or a voltage",
            Self::Short => "driven against each other",
            Self::Pulses => "pulses, darker the longer they are high",
        }
    }
}

/// The visible parts of a signal in a window.
pub(super) fn looks(wave: &[Stretch], from_ns: u64, until_ns: u64) -> impl Iterator<Item = Look> {
    let ends = wave.iter().skip(1).map(Stretch::at_ns).chain([u64::MAX]);
    let seen = wave.iter().zip(ends).filter(move |(one, end)| one.at_ns() < until_ns && *end > from_ns);
    seen.map(|(one, _)| Look::of(one))
}

/// Draws a signal around a height, in pixels. Before its first stretch nothing is known of it.
pub(super) fn draw(canvas: &mut Canvas, axis: &Axis, wave: &[Stretch], middle: f64) {
    let mut trace = Trace { middle, line: String::new(), open: String::new(), pen: None };
    for (i, stretch) in wave.iter().enumerate() {
        let end_ns = match (stretch, wave.get(i + 1)) {
            (Stretch::Pulses(pulses), _) => pulses.until_ns,
            (Stretch::Level { .. }, next) => next.map_or(u64::MAX, Stretch::at_ns),
        };
        if end_ns < axis.from_ns || stretch.at_ns() > axis.until_ns {
            trace.pen = None;
        } else {
            trace.go_on(canvas, axis, stretch, end_ns);
        }
    }
    for (data, color, dash) in [(trace.open, FRAME, "2 3"), (trace.line, ROBOT, "none")] {
        if !data.is_empty() {
            canvas.put(line(&data, color, dash));
        }
    }
}

/// A signal as far as it is drawn.
struct Trace {
    middle: f64,
    /// The paths of the driven parts, and of the others.
    line: String,
    open: String,
    /// The height that it has come to.
    pen: Option<f64>,
}

impl Trace {
    fn go_on(&mut self, canvas: &mut Canvas, axis: &Axis, stretch: &Stretch, end_ns: u64) {
        let near = |at_ns| axis.x(at_ns).clamp(axis.left - 20.0, axis.right() + 20.0);
        let (left, right) = (near(stretch.at_ns()), near(end_ns));
        match stretch {
            Stretch::Level { level: Level::Low, .. } => self.drive(self.middle + HALF, left, right),
            Stretch::Level { level: Level::High, .. } => self.drive(self.middle - HALF, left, right),
            Stretch::Level { level: Level::Open, .. } => {
                let _ = write!(self.open, "M{} {}H{}", px(left), px(self.middle), px(right));
                self.pen = Some(self.middle);
            }
            Stretch::Level { level: Level::Short, at_ns } => {
                let span = [*at_ns, end_ns.min(axis.until_ns)].map(handy_ms);
                let title = format!("driven against each other: {} to {} ms", span[0], span[1]);
                canvas.put(hatched((left, self.middle), right - left).titled(&title));
                self.pen = None;
            }
            Stretch::Pulses(pulses) => {
                draw_pulses(canvas, pulses, (left, right), axis, self.middle);
                // The pulses end where the wire rises.
                self.pen = Some(self.middle + HALF);
            }
        }
    }

    /// Goes to a height, and on to the right.
    fn drive(&mut self, y: f64, left: f64, right: f64) {
        let from = self.pen.filter(|from| from.total_cmp(&y).is_ne());
        let _ = match from {
            Some(from) => write!(self.line, "M{} {}V{}H{}", px(left), px(from), px(y), px(right)),
            None => write!(self.line, "M{} {}H{}", px(left), px(y), px(right)),
        };
        self.pen = Some(y);
    }
}

fn line(data: &str, color: &str, dash: &str) -> Element {
    let path = Element::new("path").set("d", data).set("fill", "none").set("stroke", color);
    path.set("stroke-width", "1.4").set("stroke-dasharray", dash)
}

/// Pulses as a block, with their duty and frequency in it if there is room.
fn draw_pulses(canvas: &mut Canvas, pulses: &Pulses, (left, right): (f64, f64), axis: &Axis, middle: f64) {
    let words = pulses_in_words(pulses);
    let (from, until) = (handy_ms(pulses.from_ns), handy_ms(pulses.until_ns));
    canvas.open(Element::group().titled(&format!("{} pulses, {words}: {from} to {until} ms", pulses.count)));
    let whole = rectangle((left, middle - HALF), ((right - left).max(1.0), 2.0 * HALF));
    canvas.put(whole.clone().set("fill", WHITE));
    canvas.put(shade(whole, pulses.duty()));
    let (left, right) = (left.max(axis.left), right.min(axis.right()));
    let short = words.split(", ").next().unwrap_or_default();
    if let Some(label) =
        [words.as_str(), short].into_iter().find(|label| width(label, SIZE) + 8.0 <= right - left)
    {
        let ink = if pulses.duty() > DARK { WHITE } else { INK };
        let label = text((0.5 * (left + right), middle + 0.36 * SIZE), SIZE, ink, label);
        canvas.put(label.set("text-anchor", "middle"));
    }
    canvas.close("g");
}

/// The shade of a duty.
fn shade(block: Element, duty: f64) -> Element {
    let opacity = LIGHTEST + (DARKEST - LIGHTEST) * duty.clamp(0.0, 1.0);
    block.set("fill", ROBOT).number("fill-opacity", opacity).set("stroke", ROBOT).set("stroke-width", "1")
}

/// A part whose middle on the left is at a place, and so wide.
fn hatched((left, middle): (f64, f64), wide: f64) -> Element {
    let wide = wide.max(2.0);
    let stripes = (0..(wide / 5.0) as usize).fold(String::new(), |mut stripes, i| {
        let x = left + 5.0 * i as f64;
        let _ = write!(stripes, "M{} {}l5 -{}", px(x), px(middle + HALF), px(2.0 * HALF));
        stripes
    });
    let (top, bottom) = (middle - HALF, middle + HALF);
    let rim = format!("M{0} {1}h{2}V{3}H{0}z", px(left), px(top), px(wide), px(bottom));
    let path = Element::new("path").set("d", &(rim + &stripes)).set("stroke", LATE);
    path.set("stroke-width", "1.2").set("fill", LATE).set("fill-opacity", "0.12")
}

/// A sample for the key.
pub(super) fn sample(x: f64, y: f64, look: Look) -> Element {
    match look {
        Look::Driven => line(&format!("M{} {}h5v-9h5v9h5", px(x), px(y + 4.5)), ROBOT, "none"),
        Look::Open => line(&format!("M{} {}h15", px(x), px(y)), FRAME, "2 3"),
        Look::Short => Element::group()
            .set("transform", &format!("translate({} {}) scale(0.7)", px(x), px(y)))
            .with(hatched((0.0, 0.0), 20.0)),
        Look::Pulses => shade(rectangle((x, y - 5.0), (14.0, 10.0)), 0.4),
    }
}

/// The distance from the middle to high or low, in pixels.
const HALF: f64 = 0.5 * ROW - 5.0;
/// The opacity of pulses of duty 0 and 1.
const LIGHTEST: f64 = 0.12;
const DARKEST: f64 = 0.85;
/// On pulses of a greater duty text is white.
const DARK: f64 = 0.55;

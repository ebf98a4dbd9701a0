//! A timing diagram (Fig. 3.2): lanes of bars over one axis of time.

use baudbot_sim::chip::Stretch;

use super::axis::{Axis, SIZE};
use super::class::Class;
use super::rows::rows;
use super::wave::Look;
use super::{bars, key, wave};
use crate::palette::{FRAME, GRID, INK, LATE, PALE_INK, WHITE};
use crate::quantity::duration;
use crate::svg::{self, Canvas, Element, px, text};
use crate::text::{shortened, width, without_middle, wrapped};

/// A timing diagram. Instants are nanoseconds since the start of the run.
#[derive(Debug)]
pub struct Diagram {
    /// The first line.
    pub title: String,
    /// The line below it.
    pub subtitle: String,
    /// The description of the run, line by line, if it is of a run.
    pub ran: Vec<String>,
    /// The lanes, from above.
    pub lanes: Vec<Lane>,
    /// Begin of the window.
    pub from_ns: u64,
    /// End of the window.
    pub until_ns: u64,
    /// Δt.
    pub step_ns: u64,
    /// Instants that are named above the lanes.
    pub marks: Vec<Mark>,
    /// Bars are red after this, unless they are aside.
    pub late_from_ns: Option<u64>,
}

/// A line of bars.
#[derive(Debug, PartialEq)]
pub struct Lane {
    /// The name beside it.
    pub label: String,
    /// The lane's part of the path. Neighbours of one group share a panel.
    pub group: Group,
    /// The bars, in any order. Those that overlap are below each other.
    pub bars: Vec<Bar>,
    /// The signal of a wire, in the order of time; none for a lane that is none.
    pub wave: Vec<Stretch>,
}

/// A part of the path from the sensors to the motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Sensors and their devices.
    Sensors,
    /// The pins of a chip.
    Pins,
    /// The ADC and the UART of a chip.
    Chip,
    /// The microcontroller.
    Microcontroller,
    /// Cables and adapters to the brain.
    Up,
    /// The brain.
    Brain,
    /// The cable to the microcontroller.
    Down,
    /// Motors and other actuators.
    Motors,
    /// Faults, and whatever went wrong.
    Trouble,
}

/// An event of some duration, or of none.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// The begin of the bar, in nanoseconds.
    pub start_ns: u64,
    /// The end of the bar, in nanoseconds. A bar without duration is a mark.
    pub end_ns: u64,
    /// The text in the bar, or beside it, if there is room.
    pub label: String,
    /// The tooltip of the bar.
    pub title: String,
    /// The class of the bar.
    pub class: Class,
    /// The diagram is about something else: the bar is pale and never red.
    pub is_aside: bool,
}

/// An instant that is named above the lanes.
#[derive(Debug)]
pub struct Mark {
    /// The instant.
    pub at_ns: u64,
    /// The name of the mark.
    pub label: String,
}

impl Bar {
    /// Whether it took no time.
    pub(super) fn is_mark(&self) -> bool {
        self.end_ns <= self.start_ns
    }

    /// Whether it is red once it is late. Events of trouble have their own colours.
    pub(super) fn can_be_late(&self) -> bool {
        !self.is_aside && !self.class.style().is_trouble
    }
}

/// A lane with its place: its rows and where it begins, in pixels.
struct Placed<'a> {
    lane: &'a Lane,
    rows: Vec<Vec<&'a Bar>>,
    top: f64,
}

impl Placed<'_> {
    fn bottom(&self) -> f64 {
        self.top + self.rows.len() as f64 * ROW
    }
}

impl Diagram {
    /// The diagram of a part of a robot's run, from an instant to another.
    pub fn of_run(
        robot: &str,
        world: &str,
        lanes: Vec<Lane>,
        (from_ns, until_ns): (u64, u64),
        step_ns: u64,
    ) -> Self {
        let step = duration(step_ns as f64);
        Self {
            title: format!("{robot} in {world}"),
            subtitle: format!("Events from the sensors to the brain and back. Δt = {step}."),
            ran: Vec::new(),
            lanes,
            from_ns,
            until_ns,
            step_ns,
            marks: Vec::new(),
            late_from_ns: None,
        }
    }

    /// The picture as SVG.
    pub fn draw(&self) -> String {
        let left = self.left();
        let axis = Axis { from_ns: self.from_ns, until_ns: self.until_ns, left, width: PLOT };
        let wrap = |text: &str| wrapped(text, 13.0, left + PLOT - MARGIN, 2);
        let lines: Vec<_> =
            std::iter::once(&self.subtitle).chain(&self.ran).flat_map(|text| wrap(text)).collect();
        let head = 46.0 + 18.0 * lines.len() as f64;
        let marks = if self.marks.is_empty() { 0.0 } else { 18.0 };
        let top = head + marks + ABOVE;
        let placed = self.place(top);
        let bottom = placed.last().map_or(top, Placed::bottom) + PAD;
        let mut canvas = Canvas::default();
        self.write_head(&mut canvas, &lines, left + PLOT - MARGIN);
        panels(&mut canvas, &placed, &axis);
        self.draw_time(&mut canvas, &axis, (top, bottom));
        self.draw_marks(&mut canvas, &axis, (head + 10.0, bottom));
        self.draw_bars(&mut canvas, &placed, &axis);
        let is_late = self.late_from_ns.is_some();
        let (classes, looks) = (self.classes(), self.looks());
        let height = key::draw(&mut canvas, (&classes, &looks), is_late, (left, bottom + BELOW), PLOT);
        self.document((left + PLOT + MARGIN, bottom + BELOW + height + 12.0), &canvas)
    }

    /// The left edge of the plot: beside the longest label.
    fn left(&self) -> f64 {
        let widest = self.lanes.iter().map(|lane| width(&lane.label, LABEL)).fold(0.0, f64::max);
        MARGIN + widest.clamp(80.0, 210.0) + 22.0
    }

    fn place(&self, top: f64) -> Vec<Placed<'_>> {
        let mut placed: Vec<Placed<'_>> = Vec::new();
        for lane in &self.lanes {
            let top = match placed.last() {
                None => top + PAD,
                Some(last) if last.lane.group == lane.group => last.bottom(),
                Some(last) => last.bottom() + GAP + 2.0 * PAD,
            };
            placed.push(Placed { lane, rows: rows(&lane.bars), top });
        }
        placed
    }

    fn classes(&self) -> Vec<Class> {
        let mut classes: Vec<_> =
            self.lanes.iter().flat_map(|lane| &lane.bars).map(|bar| bar.class).collect();
        classes.sort_unstable();
        classes.dedup();
        classes
    }

    fn looks(&self) -> Vec<Look> {
        let mut looks: Vec<_> =
            self.lanes.iter().flat_map(|lane| wave::looks(&lane.wave, self.from_ns, self.until_ns)).collect();
        looks.sort_unstable();
        looks.dedup();
        looks
    }

    fn write_head(&self, canvas: &mut Canvas, lines: &[String], room: f64) {
        let title = shortened(&self.title, 20.0, room);
        canvas.put(text((MARGIN, 36.0), 20.0, INK, &title).set("font-weight", "600"));
        for (i, line) in lines.iter().enumerate() {
            canvas.put(text((MARGIN, 56.0 + 18.0 * i as f64), 13.0, PALE_INK, line));
        }
    }

    /// Ticks, the axis, the boundaries of steps, and what is late.
    fn draw_time(&self, canvas: &mut Canvas, axis: &Axis, (top, bottom): (f64, f64)) {
        let ticks = axis.ticks();
        let line = |at: u64, from: f64, to: f64| format!("M{} {}V{}", px(axis.x(at)), px(from), px(to));
        let grid: String = ticks.iter().map(|(at, _)| line(*at, top, bottom)).collect();
        canvas.put(stroke(&grid, "#e6e9ef", "1"));
        if let Some(until) = self.late_until_ns() {
            let from = axis.x(self.late_from_ns.unwrap_or(until)).clamp(axis.left, axis.right());
            let until = axis.x(until).clamp(from, axis.right());
            let late = rectangle((from, top), (until - from, bottom - top));
            canvas.put(late.set("fill", LATE).set("fill-opacity", "0.07"));
        }
        self.draw_steps(canvas, axis, (top, bottom));
        let line_below = format!("M{} {}H{}", px(axis.left), px(bottom), px(axis.right()));
        let short: String = ticks.iter().map(|(at, _)| line(*at, bottom, bottom + 5.0)).collect();
        canvas.put(stroke(&(line_below + &short), FRAME, "1"));
        for (at, label) in ticks {
            let tick = text((axis.x(at), bottom + 18.0), SIZE, PALE_INK, &label);
            canvas.put(tick.set("text-anchor", "middle"));
        }
        canvas.put(text((MARGIN, bottom + 18.0), SIZE, PALE_INK, "time in ms"));
    }

    /// The end of what is late, if anything is.
    fn late_until_ns(&self) -> Option<u64> {
        let from = self.late_from_ns?;
        let bars = self.lanes.iter().flat_map(|lane| &lane.bars).filter(|bar| bar.can_be_late());
        bars.map(|bar| bar.end_ns).max().filter(|end| *end > from)
    }

    /// The boundaries of steps, and between them arrows that are Δt long.
    fn draw_steps(&self, canvas: &mut Canvas, axis: &Axis, (top, bottom): (f64, f64)) {
        let step_px = axis.x(self.from_ns.saturating_add(self.step_ns)) - axis.left;
        let boundaries = axis.multiples(self.step_ns, (PLOT / LEAST_STEP) as usize);
        let lines: String = boundaries
            .iter()
            .map(|at| format!("M{} {}V{}", px(axis.x(*at)), px(top - 18.0), px(bottom)))
            .collect();
        let is_dense = step_px < 46.0;
        let (color, wide) = if is_dense { (DENSE_STEP, "0.8") } else { (STEP, "1.2") };
        canvas.put(stroke(&lines, color, wide).set("stroke-dasharray", "5 3"));
        if is_dense {
            return;
        }
        let whole = format!("Δt = {}", duration(self.step_ns as f64));
        for (i, pair) in boundaries.windows(2).enumerate() {
            let (from, to) = (axis.x(pair[0]) + 2.0, axis.x(pair[1]) - 2.0);
            let is_told = i == 0 && width(&whole, SIZE) + 30.0 < step_px;
            let label = if is_told { &whole } else { "Δt" };
            dimension(canvas, (from, to), top - 12.0, label);
        }
    }

    fn draw_bars(&self, canvas: &mut Canvas, placed: &[Placed<'_>], axis: &Axis) {
        let (left, width) = (axis.left - 6.0, axis.width + 12.0);
        let bottom = placed.last().map_or(1.0, Placed::bottom);
        let window = rectangle((left, 0.0), (width, bottom + PAD));
        canvas.put(Element::new("clipPath").set("id", "plot").with(window));
        canvas.open(Element::group().set("clip-path", "url(#plot)"));
        for lane in placed {
            for (i, row) in lane.rows.iter().enumerate() {
                let middle = lane.top + (i as f64 + 0.5) * ROW;
                bars::draw(canvas, axis, row, middle, self.late_from_ns);
            }
            wave::draw(canvas, axis, &lane.lane.wave, lane.top + 0.5 * ROW);
        }
        canvas.close("g");
    }

    fn draw_marks(&self, canvas: &mut Canvas, axis: &Axis, (top, bottom): (f64, f64)) {
        let mut free_from = 0.0;
        for mark in self.marks.iter().filter(|mark| (self.from_ns..=self.until_ns).contains(&mark.at_ns)) {
            let x = axis.x(mark.at_ns);
            let half = 0.5 * width(&mark.label, SIZE);
            let middle = x.clamp(axis.left + half, (axis.right() - half).max(axis.left + half));
            let line = format!("M{} {}V{}", px(x), px(top + 6.0), px(bottom));
            canvas.put(stroke(&line, INK, "1").set("stroke-dasharray", "1.5 2.5"));
            if middle - half >= free_from {
                let label = text((middle, top + 2.0), SIZE, INK, &mark.label);
                canvas.put(label.set("text-anchor", "middle"));
                free_from = middle + half + 8.0;
            }
        }
    }

    /// The whole file.
    fn document(&self, (width, height): (f64, f64), inside: &Canvas) -> String {
        let (width, height) = (width.ceil(), height.ceil());
        let root = svg::root((width, height)).set("role", "img").set("font-family", FONT);
        let mut canvas = Canvas::default();
        canvas.open(root.titled(&format!("Timing diagram of {}", self.title)));
        canvas.put(Element::new("desc").text(&format!("{} ", self.subtitle)));
        canvas.put(svg::paper((width, height)));
        canvas.append(inside);
        canvas.close("svg");
        canvas.into_text()
    }
}

/// A white panel below each group's lanes, and the lanes' names.
fn panels(canvas: &mut Canvas, placed: &[Placed<'_>], axis: &Axis) {
    for group in placed.chunk_by(|a, b| a.lane.group == b.lane.group) {
        let (Some(first), Some(last)) = (group.first(), group.last()) else { continue };
        let (left, top) = (MARGIN - 8.0, first.top - PAD);
        let size = (axis.right() + 8.0 - left, last.bottom() + PAD - top);
        let panel = rectangle((left, top), size).set("rx", "5");
        canvas.put(panel.set("fill", WHITE).set("stroke", GRID));
    }
    for lane in placed {
        let name = without_middle(&lane.lane.label, LABEL, axis.left - MARGIN - 22.0);
        let middle = 0.5 * (lane.top + lane.bottom());
        let at = text((axis.left - 12.0, middle + 4.0), LABEL, INK, &name).set("text-anchor", "end");
        canvas.put(if name == lane.lane.label { at } else { at.titled(&lane.lane.label) });
    }
}

/// An arrow between two places with a text on it.
fn dimension(canvas: &mut Canvas, (from, to): (f64, f64), y: f64, label: &str) {
    let middle = 0.5 * (from + to);
    let half = 0.5 * width(label, SIZE) + 4.0;
    let head = |x: f64, way: f64| {
        format!(
            "M{} {}L{} {}L{} {}",
            px(x + 5.0 * way),
            px(y - 3.0),
            px(x),
            px(y),
            px(x + 5.0 * way),
            px(y + 3.0)
        )
    };
    let lines =
        format!("M{} {1}H{2}M{3} {1}H{4}", px(from), px(y), px(middle - half), px(middle + half), px(to));
    canvas.put(stroke(&(lines + &head(from, 1.0) + &head(to, -1.0)), STEP, "1"));
    canvas.put(text((middle, y + 4.0), SIZE, STEP, label).set("text-anchor", "middle"));
}

/// A rectangle whose sides are never negative.
pub(super) fn rectangle(corner: (f64, f64), (width, height): (f64, f64)) -> Element {
    svg::rectangle(corner, (width.max(0.0), height.max(0.0)))
}

fn stroke(data: &str, color: &str, width: &str) -> Element {
    Element::new("path").set("d", data).set("stroke", color).set("stroke-width", width).set("fill", "none")
}

const FONT: &str = "system-ui, 'DejaVu Sans', Helvetica, Arial, sans-serif";
/// Width of the plot, in pixels.
pub(super) const PLOT: f64 = 920.0;
/// Around all, in pixels.
const MARGIN: f64 = 24.0;
/// Height of a row of bars, in pixels.
pub(super) const ROW: f64 = 24.0;
/// Above and below the lanes of a panel, in pixels.
const PAD: f64 = 4.0;
/// The gap between two panels, in pixels.
const GAP: f64 = 6.0;
/// The height of the labels of Δt above the lanes, in pixels.
const ABOVE: f64 = 28.0;
/// The height of the axis, in pixels.
const BELOW: f64 = 40.0;
/// Size of the lanes' names.
const LABEL: f64 = 12.0;
/// Boundaries of steps nearer than this, in pixels, are not drawn.
const LEAST_STEP: f64 = 6.0;
/// Boundaries of steps.
const STEP: &str = "#78829a";
/// Boundaries of steps that are near each other.
const DENSE_STEP: &str = "#b3bac8";

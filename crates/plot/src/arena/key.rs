//! Keys of colours and marks: tables of the robots' sensors, and lists of everything else.

use baudbot_sim::Scenario;
use baudbot_sim::arena::Arena;
use baudbot_sim::sensor::{Device, Sensor, SensorKind};

use super::block::{Block, WIDTH};
use super::ground::candela;
use super::kinds::Kind;
use super::{Shown, senses};
use crate::palette::{self, FIELDS, INK, LAMP, LAMP_RIM, MOVABLE, MOVER, PALE_INK, WALL, WHITE, ZoneUses};
use crate::quantity::{NOTHING, count, length};
use crate::svg::{Canvas, Element, drawn, px, rectangle, text};
use crate::text::{shortened, without_middle, wrapped};

/// The table of the sensors of a kind of robot.
pub(super) fn of_kind(kind: &Kind<'_>) -> Block {
    let mut canvas = Canvas::default();
    let more = if kind.count > 1 { format!(" and {} more like it", kind.count - 1) } else { String::new() };
    let name = format!("{}{more}", shortened(&kind.robot.name, 13.0, 170.0));
    canvas.put(text((0.0, 12.0), 13.0, INK, &name).set("font-weight", "600"));
    let drive = &kind.robot.drive;
    let wheels =
        format!("wheels of {}, {} apart", length(drive.wheel_radius_m), length(2.0 * drive.half_track_m));
    let body = match kind.robot.outline.len() {
        0 => format!("robot of radius {}", length(drive.radius_m)),
        corners => format!("robot with {corners} corners"),
    };
    canvas.put(text((0.0, 28.0), SIZE, PALE_INK, &format!("{body}, {wheels}")));
    let mut y = 46.0;
    if !kind.robot.sensors.is_empty() {
        row(&mut canvas, y, ["sensor", "kind", "range", "period"], PALE_INK);
        canvas.put(
            drawn(&format!("M0 {}H{WIDTH}", y + 4.5))
                .set("stroke", palette::FRAME)
                .set("stroke-width", "0.7"),
        );
        y += LINE + 2.0;
    }
    let alike = alike(&kind.robot.sensors);
    for sensors in alike.iter().take(MOST_ROWS) {
        y = sensor_row(&mut canvas, y, kind, sensors);
    }
    if alike.len() > MOST_ROWS {
        let more = format!("and {} more", count(alike.len() - MOST_ROWS, "sensor"));
        canvas.put(text((20.0, y), SIZE, PALE_INK, &more));
        y += LINE;
    }
    Block { canvas, height: y - 8.0 }
}

/// A note that there are robots of other kinds.
pub(super) fn of_rest() -> Block {
    let mut canvas = Canvas::default();
    canvas.put(text((0.0, 12.0), SIZE, PALE_INK, "There are robots of other kinds, too."));
    Block { canvas, height: 14.0 }
}

/// Notes line by line, the first in bold, and the key of marks.
pub(super) fn of_marks(notes: &[String], marks: Vec<(Element, &'static str)>) -> Block {
    let mut canvas = Canvas::default();
    let mut y = 12.0;
    for (i, note) in notes.iter().enumerate() {
        for line in wrapped(note, SIZE + 1.0, WIDTH, 2) {
            let text = text((0.0, y), SIZE, INK, &line);
            canvas.put(if i == 0 { text.set("font-weight", "600") } else { text });
            y += LINE + 1.5;
        }
    }
    y += 4.0;
    for (mark, what) in marks {
        canvas.put(mark.set("transform", &format!("translate(0 {})", px(y - 9.0))));
        canvas.put(text((22.0, y), SIZE, INK, what));
        y += LINE + 2.5;
    }
    Block { canvas, height: y - 8.0 }
}

/// The key of zones, lamps, fields and marks, unless there are none.
pub(super) fn of_surroundings(scenario: &Scenario, shown: Shown<'_>) -> Option<Block> {
    let mut canvas = Canvas::default();
    let mut y = 12.0;
    let mut entry = |mark: Element, what: &str| {
        canvas.put(mark.set("transform", &format!("translate(0 {})", y - 9.0)));
        for line in wrapped(what, SIZE, WIDTH - 24.0, 2) {
            canvas.put(text((22.0, y), SIZE, INK, &line));
            y += LINE;
        }
        y += 2.0;
    };
    for (mark, what) in entries(scenario, shown).into_iter().take(MOST_ROWS) {
        entry(mark, &what);
    }
    (y > 12.0).then_some(Block { canvas, height: y - 8.0 })
}

fn entries(scenario: &Scenario, shown: Shown<'_>) -> Vec<(Element, String)> {
    let around = &scenario.surroundings;
    let mut entries = marks(scenario, shown);
    for zone in &around.zones {
        let uses = ZoneUses::from(zone);
        let (hue, uses) = (uses.color(), uses.words());
        let fill = match (zone.floor, uses.len()) {
            (Some(floor), 1) => palette::floor(floor),
            _ => format!("url(#hatch-{})", &hue[1..]),
        };
        let mark = rectangle((0.0, 0.0), (15.0, 10.0)).set("fill", &fill).set("stroke", hue);
        entries.push((mark, format!("zone {}: {}", zone.name, uses.join(", "))));
    }
    for light in &around.lights {
        let mark = Element::new("circle").set("cx", "7.5").set("cy", "5").set("r", "5").set("fill", LAMP);
        let what =
            format!("lamp {}: {}, {} high", light.name, candela(light.intensity_cd), length(light.height_m));
        entries.push((mark.set("stroke", LAMP_RIM), what));
    }
    for (i, field) in around.fields.iter().enumerate() {
        let mark = Element::new("circle").set("cx", "7.5").set("cy", "5").set("r", "5");
        let mark = mark.set("fill", FIELDS[i % FIELDS.len()]).set("fill-opacity", "0.55");
        let bells = count(field.sources.len(), "bell");
        let slope = if field.slope_per_m == (0.0, 0.0) { "" } else { ", and a slope" };
        entries.push((mark, format!("field {}: {bells} with rings at 1σ and 2σ{slope}", field.name)));
    }
    entries
}

/// The marks that are in the picture.
fn marks(scenario: &Scenario, shown: Shown<'_>) -> Vec<(Element, String)> {
    let with_robots = matches!(shown, Shown::Starts);
    let with_wheels = with_robots || matches!(shown, Shown::Trails(_));
    let mut devices =
        scenario.robots.iter().flat_map(|robot| robot.sensors.iter()).map(|sensor| &sensor.device);
    let turrets = with_robots
        && scenario.robots.iter().any(|robot| robot.actuators.iter().any(|a| a.kind() == "turret"));
    let line = |data: &str| drawn(data).set("fill", "none").set("stroke-width", "1.6");
    let dashed = rectangle((0.0, 0.0), (15.0, 10.0)).set("fill", "#dadde2").set("stroke", WALL);
    let movable = rectangle((1.0, 0.0), (13.0, 10.0)).set("fill", MOVABLE);
    let wheel = drawn("M0 2H15V8H0ZM3 2V8M7 2V8M11 2V8").set("fill", INK).set("stroke", WHITE);
    let rays = with_robots && devices.clone().any(|device| device.fan().is_some());
    let all = [
        (rays, ray(), "a ray, with a dot where it meets something"),
        (
            has_low_walls(&scenario.arena),
            dashed.set("stroke-dasharray", "4 2"),
            "low, with its height: sensors that sit higher overlook it",
        ),
        (
            !scenario.movers.is_empty(),
            line("M0 5H15").set("stroke", MOVER).set("stroke-dasharray", "5 3"),
            "the path of a moving thing; dots around a wandering one",
        ),
        (!scenario.movables.is_empty(), movable.set("stroke", "#78603c"), "can be pushed"),
        (
            with_wheels && devices.any(|device| matches!(device, Device::Encoders(_))),
            wheel.set("stroke-width", "1"),
            "a wheel with an encoder",
        ),
        (
            turrets,
            line("M2 9A6.5 6.5 0 0 1 13 9").set("stroke", palette::INNER).set("stroke-width", "3"),
            "how far a turret turns",
        ),
    ];
    all.into_iter().filter(|(is, ..)| *is).map(|(_, mark, what)| (mark, what.to_owned())).collect()
}

fn has_low_walls(arena: &Arena) -> bool {
    let walls = arena.polygons().iter().map(|polygon| &polygon.look);
    walls.chain(arena.pillars().iter().map(|pillar| &pillar.look)).any(|look| look.height_m.is_finite())
}

fn ray() -> Element {
    let dot = Element::new("circle").set("cx", "13").set("cy", "4").set("r", "2");
    let group = Element::group()
        .set("fill", SensorKind::Infrared.style().color)
        .set("stroke", SensorKind::Infrared.style().color);
    group.with(drawn("M0 8L13 4")).with(dot.set("stroke", "none"))
}

/// The rows of the table: sensors that differ in name and mount only share one.
fn alike(sensors: &[Sensor]) -> Vec<Vec<&Sensor>> {
    let key = |sensor: &Sensor| (sensor.device.kind(), range(sensor), senses::period(sensor));
    let mut rows: Vec<Vec<&Sensor>> = Vec::new();
    for sensor in sensors {
        match rows.iter_mut().find(|row| key(row[0]) == key(sensor)) {
            Some(row) => row.push(sensor),
            None => rows.push(vec![sensor]),
        }
    }
    rows
}

fn range(sensor: &Sensor) -> String {
    sensor.device.range_m().map_or_else(|| NOTHING.to_owned(), length)
}

/// Draws a row, and returns where the next one begins.
fn sensor_row(canvas: &mut Canvas, y: f64, kind: &Kind<'_>, sensors: &[&Sensor]) -> f64 {
    let first = sensors[0];
    let titles: Vec<_> = sensors.iter().take(16).map(|sensor| senses::title(kind.robot, sensor)).collect();
    canvas.open(Element::group().titled(&titles.join("; ")));
    let color = first.device.sensor_kind().style().color;
    // A sensor with a direction has a wedge, all else a dot.
    canvas.put(match first.device.fan() {
        Some(_) => drawn(&format!("M1 {}L14 {}V{}Z", y - 4.0, y - 9.5, y + 1.5)).set("fill", color),
        None => {
            Element::new("circle").set("cx", "7").number("cy", y - 4.0).set("r", "3.6").set("fill", color)
        }
    });
    let names: Vec<_> = sensors.iter().map(|sensor| without_middle(&sensor.name, SIZE, NAMES)).collect();
    let lines = wrapped(&names.join(", "), SIZE, NAMES, 6);
    row(canvas, y, ["", first.device.kind(), &range(first), &senses::period(first)], INK);
    for (i, line) in lines.iter().enumerate() {
        canvas.put(text((20.0, y + i as f64 * LINE), SIZE, INK, line));
    }
    canvas.close("g");
    y + lines.len() as f64 * LINE + 1.5
}

fn row(canvas: &mut Canvas, y: f64, [name, kind, range, period]: [&str; 4], color: &str) {
    let right = |x: f64, cell: &str| text((x, y), SIZE, color, cell).set("text-anchor", "end");
    if !name.is_empty() {
        canvas.put(text((20.0, y), SIZE, color, name));
    }
    canvas.put(text((20.0 + NAMES + 6.0, y), SIZE, color, kind));
    canvas.put(right(WIDTH - 54.0, range));
    canvas.put(right(WIDTH, period));
}

/// Size of letters, in pixels.
const SIZE: f64 = 11.0;
/// Height of a line, in pixels.
const LINE: f64 = 14.5;
/// Room for names, in pixels.
const NAMES: f64 = 118.0;
/// The most rows of a list.
const MOST_ROWS: usize = 40;

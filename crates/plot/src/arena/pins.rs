//! The chip of a robot that runs a program of the user's own, and what is on its pins.

use baudbot_sim::chip::{ChipSpec, Net};

use super::block::{Block, WIDTH};
use super::kinds::Kind;
use crate::palette::{BODY, FRAME, INK, PALE_INK, ROBOT};
use crate::svg::{Canvas, Element, Place, rectangle, text};
use crate::text::shortened;

/// The chip of the first robot of a kind, if it has one.
pub(super) fn draw(kind: &Kind<'_>) -> Option<Block> {
    let chip = kind.robot.chip.as_deref()?;
    let mut canvas = Canvas::default();
    let part = chip.board().chip().part().properties().name;
    let head = format!("{}: {part} at {} MHz", kind.robot.name, f64::from(chip.board().clock().hz()) / 1e6);
    canvas.put(text((0.0, 12.0), 13.0, INK, &shortened(&head, 13.0, WIDTH)).set("font-weight", "600"));
    let digital: Vec<_> = (0..14).rev().filter_map(Net::arduino).collect();
    let analog: Vec<_> = (14..20).filter_map(Net::arduino).collect();
    let others = [Net::AnalogOnly(6), Net::AnalogOnly(7), Net::Supply, Net::Ground];
    let others =
        others.into_iter().filter(|net| chip.board().wiring().wires().any(|(_, there)| there == *net));
    let left: Vec<_> = analog.into_iter().chain(others).collect();
    let rows = digital.len().max(left.len());
    let height = rows as f64 * ROW + 8.0;
    let corner = (0.5 * (WIDTH - CHIP), HEAD);
    let outline = rectangle(corner, (CHIP, height)).set("rx", "6").set("fill", BODY).set("stroke", FRAME);
    canvas.put(outline.titled(part));
    for (i, net) in left.iter().enumerate() {
        pin(&mut canvas, chip, *net, (corner.0, row(i)), Side::Left);
    }
    for (i, net) in digital.iter().enumerate() {
        pin(&mut canvas, chip, *net, (corner.0 + CHIP, row(i)), Side::Right);
    }
    Some(Block { canvas, height: HEAD + height })
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Left,
    Right,
}

/// A pin with its name inside the chip, and what is on it outside.
fn pin(canvas: &mut Canvas, chip: &ChipSpec, net: Net, (x, y): Place, side: Side) {
    let wiring = chip.board().wiring();
    let on =
        wiring.wires().filter(|(_, there)| *there == net).map(|(terminal, _)| wiring.terminal_name(terminal));
    let on: Vec<_> = on.collect();
    let (way, anchor, inside) = match side {
        Side::Left => (-1.0, "end", "start"),
        Side::Right => (1.0, "start", "end"),
    };
    let ink = if on.is_empty() { FRAME } else { ROBOT };
    let leg =
        Element::new("line").number("x1", x).number("y1", y).number("x2", x + way * LEG).number("y2", y);
    canvas.put(leg.set("stroke", ink).set("stroke-width", if on.is_empty() { "1" } else { "2.5" }));
    let name = text((x - way * 5.0, y + 3.5), SIZE, if on.is_empty() { FRAME } else { INK }, &net.printed());
    canvas.put(name.set("text-anchor", inside));
    if !on.is_empty() {
        let room = 0.5 * (WIDTH - CHIP) - LEG - 4.0;
        let label = shortened(&on.join(", "), SIZE, room);
        let at = text((x + way * (LEG + 4.0), y + 3.5), SIZE, PALE_INK, &label).set("text-anchor", anchor);
        canvas.put(at.titled(&format!("{}: {}", net.printed(), on.join(", "))));
    }
}

fn row(i: usize) -> f64 {
    HEAD + 4.0 + (i as f64 + 0.5) * ROW
}

/// Height of a row, in pixels.
const ROW: f64 = 15.0;
/// The chip's top below its name.
const HEAD: f64 = 22.0;
/// Width of the chip.
const CHIP: f64 = 64.0;
/// Length of a pin.
const LEG: f64 = 9.0;
const SIZE: f64 = 10.5;

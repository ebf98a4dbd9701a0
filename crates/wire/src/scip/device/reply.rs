//! Writes answers.

use core::fmt::{self, Write};

use super::command::{Scans, Steps};
use super::machine::HEAD_END;
use super::{Description, INTENSITY, Model, Rate};
use crate::scip::{BLOCK_LEN, Characters, FIRST_CHARACTER, LEAST_RANGE_MM, LINE_FEED, TIME_LEN};

/// An answer on its way.
pub(super) struct Reply<'a, E> {
    out: &'a mut E,
    /// The bytes of the line that are not in `out` yet: a line at a time is quicker than a character.
    line: [u8; BLOCK_LEN + 2],
    held: usize,
    /// The sum of the line's characters.
    sum: u8,
    /// Characters in the line so far.
    len: usize,
}

/// The content of a scan, and its part.
#[derive(Clone, Copy)]
pub(super) struct ScanLayout {
    pub(super) scans: Scans,
    pub(super) steps: Steps,
}

impl<'a, E: Extend<u8>> Reply<'a, E> {
    pub(super) const fn new(out: &'a mut E) -> Self {
        Self { out, line: [0; BLOCK_LEN + 2], held: 0, sum: 0, len: 0 }
    }

    pub(super) fn echo(&mut self, line: &[u8]) {
        self.out.extend(line.iter().copied());
        self.out.extend([LINE_FEED]);
    }

    /// The echo of a command with the scans that remain in place of those that were asked for.
    pub(super) fn echo_of_scan(&mut self, line: &[u8], left: u8) {
        let (head, text) = line.split_at_checked(HEAD_END).unwrap_or_default();
        self.out.extend(head.iter().copied().take(HEAD_END - 2));
        self.out.extend([b'0' + left / 10 % 10, b'0' + left % 10]);
        self.echo(text);
    }

    pub(super) fn status(&mut self, status: [u8; 2]) {
        status.into_iter().for_each(|byte| self.put(byte));
        self.end_line();
    }

    /// The last of the two line feeds.
    pub(super) fn end(&mut self) {
        self.out.extend([LINE_FEED]);
    }

    pub(super) fn state(&mut self, state: [u8; 3]) {
        state.into_iter().for_each(|byte| self.put(byte));
        self.end_line();
    }

    pub(super) fn time(&mut self, time_ms: u32) {
        self.code(time_ms, TIME_LEN);
        self.end_line();
    }

    pub(super) fn versions(&mut self, facts: &Description) {
        self.text(format_args!("VEND:{VENDOR}"));
        let product = product(facts.model);
        self.text(format_args!("PROD:SOKUIKI Sensor {product}"));
        self.text(format_args!("FIRM:baudbot"));
        self.text(format_args!("PROT:SCIP 2.0"));
        self.text(format_args!("SERI:H0000001"));
    }

    pub(super) fn parameters(&mut self, facts: &Description) {
        self.model(facts.model);
        self.text(format_args!("DMIN:{}", facts.least_mm));
        self.text(format_args!("DMAX:{}", facts.most_mm));
        self.text(format_args!("ARES:{}", facts.steps_per_turn));
        self.text(format_args!("AMIN:{}", facts.first_step));
        self.text(format_args!("AMAX:{}", facts.last_step));
        self.text(format_args!("AFRT:{}", facts.front_step));
        self.text(format_args!("SCAN:{}", facts.turns_per_minute));
    }

    pub(super) fn information(&mut self, facts: &Description, rate: Rate, time_ms: u32, is_lit: bool) {
        self.model(facts.model);
        self.text(format_args!("LASR:{}", if is_lit { "ON" } else { "OFF" }));
        self.text(format_args!("SCSP:Initial({}[rpm])", facts.turns_per_minute));
        self.text(format_args!("MESM:{}", if is_lit { "Measuring" } else { "IDLE" }));
        match rate {
            Some(rate) => self.text(format_args!("SBPS:{rate}[bps]")),
            None => self.text(format_args!("SBPS:USB only")),
        }
        self.text(format_args!("TIME:{time_ms:06X}"));
        match facts.model {
            Model::Urg04lx => self.text(format_args!("STAT:Sensor works well.")),
            Model::Ust10lx => self.text(format_args!("STAT:Stable 000 no error.")),
        }
    }

    fn model(&mut self, model: Model) {
        let product = product(model);
        self.text(format_args!("MODL:{product}({VENDOR})"));
    }

    /// A line of text. Its checksum does not count the semicolon before it.
    fn text(&mut self, text: fmt::Arguments<'_>) {
        // Writing to this never fails.
        let _ = self.write_fmt(text);
        let sum = FIRST_CHARACTER + (self.sum & 0x3f);
        [b';', sum, LINE_FEED].into_iter().for_each(|byte| self.hold(byte));
        self.finish_line();
    }

    pub(super) fn scan(&mut self, facts: &Description, layout: ScanLayout, time_ms: u32, ranges_m: &[f64]) {
        self.time(time_ms);
        let Steps { first, last, cluster } = layout.steps;
        let characters = match layout.scans {
            Scans::Two => Characters::Two,
            Scans::Three | Scans::Intensities => Characters::Three,
        };
        for from in (first..=last).step_by(usize::from(cluster.max(1))) {
            let steps = from..=last.min(from.saturating_add(u16::from(cluster.max(1)) - 1));
            let nearest = steps.filter_map(|step| range_mm(facts, ranges_m, step)).min();
            self.block(nearest.unwrap_or(0).min(characters.top_mm()), characters.count());
            if layout.scans == Scans::Intensities {
                self.block(if nearest.is_some() { INTENSITY } else { 0 }, characters.count());
            }
        }
        if self.len > 0 {
            self.end_line();
        }
    }

    /// A number in a block of data, which may end within it.
    fn block(&mut self, number: u32, count: usize) {
        for place in (0..count).rev() {
            self.code(number >> (6 * place), 1);
            if self.len == BLOCK_LEN {
                self.end_line();
            }
        }
    }

    /// The low 6 · `count` bits of `number` as characters.
    fn code(&mut self, number: u32, count: usize) {
        for place in (0..count).rev() {
            self.put(FIRST_CHARACTER + (number >> (6 * place) & 0x3f) as u8);
        }
    }

    fn put(&mut self, byte: u8) {
        self.hold(byte);
        self.sum = self.sum.wrapping_add(byte);
        self.len += 1;
    }

    fn end_line(&mut self) {
        self.hold(FIRST_CHARACTER + (self.sum & 0x3f));
        self.hold(LINE_FEED);
        self.finish_line();
    }

    /// A byte of the line, which may be longer than what there is room for.
    fn hold(&mut self, byte: u8) {
        if self.held == self.line.len() {
            self.release();
        }
        self.line[self.held] = byte;
        self.held += 1;
    }

    fn release(&mut self) {
        self.out.extend(self.line[..self.held].iter().copied());
        self.held = 0;
    }

    fn finish_line(&mut self) {
        self.release();
        (self.sum, self.len) = (0, 0);
    }
}

impl<E: Extend<u8>> Write for Reply<'_, E> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| self.put(byte));
        Ok(())
    }
}

/// The distance of a step in whole millimetres, if there was a measurement. One below the least that is no error code is
/// none.
fn range_mm(facts: &Description, ranges_m: &[f64], step: u16) -> Option<u32> {
    let &range_m = ranges_m.get(usize::from(step.checked_sub(facts.first_step)?))?;
    let range_mm = (range_m * 1e3 + 0.5) as u32;
    (range_m >= 0.0 && range_mm >= LEAST_RANGE_MM).then_some(range_mm)
}

const fn product(model: Model) -> &'static str {
    match model {
        Model::Urg04lx => "URG-04LX",
        Model::Ust10lx => "UST-10LX",
    }
}

const VENDOR: &str = "Hokuyo Automatic Co.,Ltd.";

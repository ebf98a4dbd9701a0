//! The stretches of a recording that can be replayed: all of it, or the parts between damaged places.

use std::fmt;

use super::{RecordedRun, Result};
use crate::error::RecordingError;

/// Ticks in a row: the state at the first is there, and all that entered the world until the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stretch {
    /// The tick at which the stretch begins.
    pub first_tick: u64,
    /// The tick at which the stretch ends.
    pub last_tick: u64,
    /// The number of gaps before it in the file.
    part: u32,
}

/// The part of a recording that can be run again and compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coverage {
    /// Nothing that was recorded is missing before the last tick.
    pub is_complete: bool,
    /// Ticks that can be.
    pub compared_ticks: u64,
    /// The number of recorded ticks; `None` if the end is missing and its place is unknown.
    pub recorded_ticks: Option<u64>,
}

impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let n = self.compared_ticks;
        match self.recorded_ticks {
            Some(all) => write!(f, "{n} of {all} ticks ({:.1} %)", 100.0 * n as f64 / all.max(1) as f64),
            None => write!(f, "the {n} ticks that are left; the file does not have their original number"),
        }
    }
}

impl Stretch {
    fn has(&self, tick: u64) -> bool {
        (self.first_tick..=self.last_tick).contains(&tick)
    }
}

/// Each state that cannot be used costs a world. A file in which so many are is none that was damaged by chance.
const MOST_UNUSABLE: usize = 1000;

impl RecordedRun {
    /// Puts the parts in order. The rest of a part behind its last mark may be incomplete, and all before its first
    /// state belongs to an unknown world.
    pub(super) fn put_in_order(mut self) -> Result<Self> {
        if self.condition.is_whole {
            // The damage was in none of the messages.
            self.inputs.iter_mut().chain(&mut self.states).for_each(|kept| kept.part = 0);
            self.marks.iter_mut().for_each(|(part, _)| *part = 0);
            self.part = 0;
        }
        self.find_stretches()?;
        if self.stretches.is_empty() {
            return Err(RecordingError::Empty);
        }
        let stretches = std::mem::take(&mut self.stretches);
        let of = |part: u32| stretches.binary_search_by_key(&part, |stretch| stretch.part).ok();
        let is_in = |part: u32, tick| of(part).is_some_and(|place| stretches[place].has(tick));
        self.inputs.retain(|kept| is_in(kept.part, kept.tick));
        self.states.retain(|kept| is_in(kept.part, kept.tick));
        self.events.retain(|event| {
            let behind = stretches.partition_point(|stretch| stretch.first_tick <= event.tick);
            stretches[..behind].last().is_some_and(|stretch| stretch.has(event.tick))
        });
        self.marks.retain(|(part, mark)| is_in(*part, mark.tick));
        self.inputs.sort_by_key(|kept| kept.tick);
        self.states.sort_by_key(|kept| kept.tick);
        self.marks.sort_by_key(|(_, mark)| mark.tick);
        // The later of two marks at one tick is kept: a manual change may have come between.
        self.marks.reverse();
        self.marks.dedup_by(|(part, earlier), (other, later)| {
            part == other && later.first_tick <= earlier.first_tick
        });
        self.marks.reverse();
        self.stretches = stretches;
        Ok(self)
    }

    /// Finds the part of each piece of the file that can be run again, behind those before it.
    fn find_stretches(&mut self) -> Result<()> {
        // Marks and states came part by part. Of a file that harms there may be millions of parts.
        let mut states = self.states.as_slice();
        let mut unusable = 0;
        for marks in self.marks.chunk_by(|(one, _), (other, _)| one == other) {
            let part = marks[0].0;
            states = &states[states.partition_point(|kept| kept.part < part)..];
            let of_part = &states[..states.partition_point(|kept| kept.part == part)];
            let ticks = marks.iter().map(|(_, mark)| mark.tick);
            let Some(last_tick) = ticks.max().filter(|&last| self.has_time(last)) else { continue };
            let before = self.stretches.last().map(|stretch| stretch.last_tick);
            let is_new = |tick: u64| tick <= last_tick && before.is_none_or(|before| tick > before);
            for kept in of_part.iter().filter(|kept| is_new(kept.tick)) {
                // The first is asked for anyway, and returns why it cannot be used.
                if part == 0 || self.state(kept)?.is_ok() {
                    self.stretches.push(Stretch { first_tick: kept.tick, last_tick, part });
                    break;
                }
                unusable += 1;
                if unusable > MOST_UNUSABLE {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Beyond that there is no time.
    fn has_time(&self, tick: u64) -> bool {
        tick <= u64::MAX / self.scenario.step_ns.max(1)
    }

    /// The parts that can be done again, in the order of ticks: one, unless something is damaged between them.
    pub fn stretches(&self) -> &[Stretch] {
        &self.stretches
    }

    /// The first and the last tick that the recording ever had, as far as the file still has them.
    pub fn extent(&self) -> (u64, u64) {
        let step_ns = self.scenario.step_ns.max(1);
        let ticks =
            self.condition.times_ns.map(|(first_ns, last_ns)| (first_ns / step_ns, last_ns / step_ns));
        let (first, last) = ticks.unwrap_or((u64::MAX, 0));
        let first = if self.begins() { self.first_tick() } else { first.min(self.first_tick()) };
        (first, last.max(self.last_tick()))
    }

    /// The part of the recording that can be run again: of all, or until a tick.
    pub fn coverage(&self, asked: Option<u64>) -> Coverage {
        let (from, until) = self.extent();
        let until = asked.map_or(until, |asked| asked.clamp(from, until));
        let compared = |stretch: &Stretch| stretch.last_tick.min(until).saturating_sub(stretch.first_tick);
        let is_end_known = self.is_end_known() || asked.is_some_and(|asked| asked <= self.last_tick());
        Coverage {
            is_complete: asked.map_or_else(|| self.is_whole(), |asked| self.has_all_until(asked)),
            compared_ticks: self.stretches.iter().map(compared).sum(),
            recorded_ticks: is_end_known.then_some(until - from),
        }
    }

    /// Whether it is known how many ticks were recorded.
    pub fn is_end_known(&self) -> bool {
        self.is_whole() || self.condition.times_ns.is_some()
    }

    /// Whether it begins with what was recorded first.
    fn begins(&self) -> bool {
        self.stretches[0].part == 0
    }

    /// Whether all that was recorded until this tick can be done again.
    pub fn has_all_until(&self, tick: u64) -> bool {
        self.is_whole() || (self.begins() && tick <= self.stretches[0].last_tick)
    }

    /// The nearest tick that can be gone to: before a gap, if this one is in it.
    pub fn nearest(&self, tick: u64) -> u64 {
        let Stretch { first_tick, last_tick, .. } = self.stretch_of(tick);
        tick.clamp(first_tick, last_tick)
    }

    /// The stretch that a tick is in or behind; before all of them, the first.
    pub(crate) fn stretch_of(&self, tick: u64) -> Stretch {
        let behind = self.stretches.partition_point(|stretch| stretch.first_tick <= tick);
        self.stretches[behind.saturating_sub(1)]
    }

    /// The next stretch behind the one of this tick.
    pub(crate) fn next_stretch(&self, tick: u64) -> Option<Stretch> {
        let behind = self.stretches.partition_point(|stretch| stretch.first_tick <= tick);
        self.stretches.get(behind).copied()
    }
}

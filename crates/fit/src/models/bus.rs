//! The time of a USB bus in the clock of a log: the rate and the phase of its frames.
//!
//! Received times are looked at in blocks of some tens of echoes, within which clocks stay in step. The rate is where the residues
//! of each block agree best. The phases of neighbouring blocks then differ by the clocks' drift; where they differ by more the
//! phase has leapt, since a clock was set or the log had a long gap, and each side has a phase of its own. A phase that
//! wanders slowly about its line is followed.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::estimate::{Reason, Remark};

/// The frames of a log.
pub(super) struct Bus {
    /// The frames' rate by the log's clock, less 1.
    rate: f64,
    pieces: Vec<Piece>,
    pub(super) remarks: Vec<Remark>,
}

/// Echoes with one line of phases.
#[derive(Clone, Debug)]
struct Piece {
    echoes: Range<usize>,
    /// Instants and the phases there; linear between them.
    phases: Vec<(f64, f64)>,
}

/// Some tens of echoes.
#[derive(Clone, Debug)]
struct Block {
    echoes: Range<usize>,
    /// The middle of its times.
    at: f64,
    /// The middle of its residues, and their scatter.
    phase: f64,
    scatter: f64,
    /// The agreement of the residues: 1 if all are the same, about 0 if they may be anything.
    agreement: f64,
}

impl Bus {
    /// The frames of echoes whose received times are in frames by the log's clock; `lines` are theirs in the log.
    pub(super) fn find(received: &[f64], lines: &[u64], frame_us: f64) -> Result<Self, Reason> {
        let ranges = ranges(received);
        let rate = coarse_rate(received, &ranges);
        let blocks: Vec<_> = ranges.into_iter().map(|range| Block::new(received, range, rate)).collect();
        let sound: Vec<Block> =
            blocks.iter().filter(|block| block.agreement > LEAST_AGREEMENT).cloned().collect();
        if 2 * sound.len() < blocks.len() || sound.is_empty() {
            let what = "the times at which echoes are received are spread over the whole frame".into();
            return Err(Reason::NoFrames { what });
        }
        let groups = groups(sound);
        if groups.leaps > MOST_LEAPS + blocks.len() / 40 {
            let what =
                format!("their phase leaps {} times in {} stretches of the log", groups.leaps, blocks.len());
            return Err(Reason::NoFrames { what });
        }
        let slope = pooled_slope(&groups.groups);
        let mut bus = Self { rate, pieces: Vec::new(), remarks: Vec::new() };
        let mut wander = 0.0_f64;
        for group in &groups.groups {
            let (piece, by) = Piece::new(group, slope);
            wander = wander.max(by);
            bus.pieces.push(piece);
        }
        bus.settle_borders(received);
        bus.tell_leaps(received, lines, frame_us);
        if wander > 0.0 {
            bus.remarks.push(Remark::Wanders { by_us: wander * frame_us });
        }
        Ok(bus)
    }

    /// A time of the log in frames since one's beginning; none where the phase is not known.
    pub(super) fn time(&self, echo: usize, time: f64) -> Option<f64> {
        let piece = self.pieces.iter().find(|piece| piece.echoes.contains(&echo))?;
        Some(time * (1.0 - self.rate) - piece.phase(time))
    }

    /// The piece that an echo is in.
    pub(super) fn piece(&self, echo: usize) -> Option<usize> {
        self.pieces.iter().position(|piece| piece.echoes.contains(&echo))
    }

    /// Settles the borders between pieces, by the piece that fits the echoes between their blocks better.
    fn settle_borders(&mut self, received: &[f64]) {
        for next in 1..self.pieces.len() {
            let (a, b) = (self.pieces[next - 1].clone(), self.pieces[next].clone());
            let from = a.echoes.end.saturating_sub(BLOCK).max(a.echoes.start);
            let to = (b.echoes.start + BLOCK).min(b.echoes.end);
            let off = |piece: &Piece, echo: usize| {
                let time = received[echo];
                let residue = time * (1.0 - self.rate) - piece.phase(time);
                (residue - residue.round()).abs().min(CLIP)
            };
            let mut cost: f64 = (from..to).map(|echo| off(&b, echo)).sum();
            let mut best = (cost, from);
            for echo in from..to {
                cost += off(&a, echo) - off(&b, echo);
                if cost < best.0 {
                    best = (cost, echo + 1);
                }
            }
            self.pieces[next - 1].echoes.end = best.1;
            self.pieces[next].echoes.start = best.1;
        }
        if let Some(first) = self.pieces.first_mut() {
            first.echoes.start = 0;
        }
        if let Some(last) = self.pieces.last_mut() {
            last.echoes.end = received.len();
        }
    }

    fn tell_leaps(&mut self, received: &[f64], lines: &[u64], frame_us: f64) {
        let mut more = 0;
        for pair in self.pieces.windows(2) {
            let at = pair[1].echoes.start.min(received.len() - 1);
            let leap = wrapped(pair[1].phase(received[at]) - pair[0].phase(received[at]));
            // The phase is not expected to stay over a long gap.
            if (received[at] - received[at.saturating_sub(1)]) * UNKNOWN_RATE > 0.2 {
                continue;
            }
            if self.remarks.len() < LISTED {
                self.remarks.push(Remark::Leap { line: lines[at], leap_us: leap * frame_us });
            } else {
                more += 1;
            }
        }
        if more > 0 {
            self.remarks.push(Remark::MoreLeaps { more });
        }
    }
}

impl Piece {
    /// The piece of some blocks whose phases drift by a slope, and how far they wander about that, if they do.
    fn new(blocks: &[Block], slope: f64) -> (Self, f64) {
        let echoes = blocks[0].echoes.start..blocks[blocks.len() - 1].echoes.end;
        let middle = blocks[blocks.len() / 2].at;
        let mut offsets: Vec<f64> =
            blocks.iter().map(|block| block.phase - slope * (block.at - middle)).collect();
        let rest = offsets.clone();
        let offset = median(&mut offsets);
        let away = (rest.iter().map(|one| (one - offset).powi(2)).sum::<f64>() / rest.len() as f64).sqrt();
        let expected = blocks.iter().map(Block::error).sum::<f64>() / blocks.len() as f64;
        if blocks.len() < 8 || away < 3.0 * expected {
            let at = |time: f64| (time, offset + slope * (time - middle));
            return (Self { echoes, phases: vec![at(middle), at(middle + 1.0)] }, 0.0);
        }
        let smooth = |i: usize| {
            let near = i.saturating_sub(SMOOTH)..(i + SMOOTH + 1).min(blocks.len());
            let mut near: Vec<f64> = rest[near].to_vec();
            (blocks[i].at, median(&mut near) + slope * (blocks[i].at - middle))
        };
        (Self { echoes, phases: (0..blocks.len()).map(smooth).collect() }, away)
    }

    fn phase(&self, time: f64) -> f64 {
        let after = self.phases.partition_point(|(at, _)| *at < time).clamp(1, self.phases.len() - 1);
        let ((from, low), (to, high)) = (self.phases[after - 1], self.phases[after]);
        low + (high - low) * (time - from) / (to - from).max(1e-9)
    }
}

impl Block {
    fn new(received: &[f64], echoes: Range<usize>, rate: f64) -> Self {
        let times = &received[echoes.clone()];
        let residues: Vec<f64> = times.iter().map(|time| (time * (1.0 - rate)).rem_euclid(1.0)).collect();
        let (sin, cos) = residues.iter().fold((0.0, 0.0), |(sin, cos), residue| {
            let one = (TAU * residue).sin_cos();
            (sin + one.0, cos + one.1)
        });
        let mean = sin.atan2(cos) / TAU;
        let mut about: Vec<f64> = residues.iter().map(|residue| wrapped(residue - mean)).collect();
        let middle = median(&mut about);
        let mut away: Vec<f64> = about.iter().map(|one| (one - middle).abs()).collect();
        Self {
            at: 0.5 * (times[0] + times[times.len() - 1]),
            phase: mean + middle,
            scatter: 1.5 * median(&mut away),
            agreement: sin.hypot(cos) / residues.len() as f64,
            echoes,
        }
    }

    /// The standard error of the phase.
    fn error(&self) -> f64 {
        1.4 * self.scatter.max(1e-4) / (self.echoes.len() as f64).sqrt()
    }
}

/// Blocks of echoes without long gaps.
fn ranges(received: &[f64]) -> Vec<Range<usize>> {
    let mut steps: Vec<f64> = received.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let longest = (GAP * median(&mut steps)).max(GAP);
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut start = 0;
    for end in 1..=received.len() {
        let is_gap = end == received.len() || received[end] - received[end - 1] > longest;
        if !is_gap && end - start < BLOCK {
            continue;
        }
        match ranges.last_mut() {
            // A rest joins the block before it.
            Some(last)
                if end - start < BLOCK / 2
                    && last.end == start
                    && received[start] - received[start - 1] <= longest =>
            {
                last.end = end;
            }
            Some(_) | None if end - start >= BLOCK / 4 => ranges.push(start..end),
            Some(_) | None => {}
        }
        start = end;
    }
    if ranges.is_empty() {
        ranges.push(0..received.len());
    }
    ranges
}

/// The rate at which the residues of blocks agree best.
fn coarse_rate(received: &[f64], ranges: &[Range<usize>]) -> f64 {
    let stride = ranges.len().div_ceil(MOST_BLOCKS);
    let span = |range: &Range<usize>| received[range.end - 1] - received[range.start];
    let looked: Vec<_> = ranges.iter().step_by(stride.max(1)).collect();
    let longest = looked.iter().map(|range| span(range)).fold(1.0, f64::max);
    let step = 0.1 / longest;
    let steps = ((MOST_RATE / step) as i64).min(MOST_RATES);
    let agreement = |rate: f64| {
        let of = |range: &Range<usize>| {
            let from = received[range.start];
            let sum = received[range.clone()].iter().fold((0.0, 0.0), |sum, time| {
                let (sin, cos) = (TAU * (time - from) * (1.0 - rate)).sin_cos();
                (sum.0 + sin, sum.1 + cos)
            });
            (sum.0 * sum.0 + sum.1 * sum.1) / range.len() as f64
        };
        looked.iter().map(|range| of(range)).sum::<f64>()
    };
    let none = agreement(0.0);
    let rates = (-steps..=steps).map(|i| i as f64 * step).map(|rate| (agreement(rate), rate));
    let mut best = rates.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((none, 0.0));
    for finer in [0.5, 0.25, 0.12, 0.06].map(|share| share * step) {
        // Blocks that are too short for a rate leave it to their phases.
        let beside = [best.1 - finer, best.1 + finer].map(|rate| rate.clamp(-MOST_RATE, MOST_RATE));
        let beside = beside.map(|rate| (if steps == 0 { 0.0 } else { agreement(rate) }, rate));
        best = beside.into_iter().fold(best, |best, one| if one.0 > best.0 { one } else { best });
    }
    // A clock that is in step explains the log as well: then it is.
    if best.0 < none * 1.0001 { 0.0 } else { best.1 }
}

/// Blocks between leaps.
struct Groups {
    groups: Vec<Vec<Block>>,
    /// Leaps that no gap explains.
    leaps: usize,
}

/// Blocks whose phases follow each other, each phase less than half a frame from the one before.
fn groups(blocks: Vec<Block>) -> Groups {
    let drift = |a: &Block, b: &Block| wrapped(b.phase - a.phase) / (b.at - a.at).max(1e-9);
    let mut drifts: Vec<f64> = blocks.windows(2).map(|pair| drift(&pair[0], &pair[1])).collect();
    let slope =
        if drifts.is_empty() { 0.0 } else { median(&mut drifts).clamp(-2.0 * MOST_RATE, 2.0 * MOST_RATE) };
    let mut found = Groups { groups: Vec::new(), leaps: 0 };
    for mut block in blocks {
        let Some(group) = found.groups.last_mut() else {
            found.groups.push(vec![block]);
            continue;
        };
        let last = &group[group.len() - 1];
        let span = block.at - last.at;
        let expected = last.phase + slope * span;
        let step = wrapped(block.phase - expected);
        // The uncertainty of the rate; over a long gap that may be anything.
        let unknown = span * UNKNOWN_RATE;
        let most = LEAP + 5.0 * last.error().hypot(block.error()) + unknown;
        if step.abs() < most && unknown < 0.2 {
            block.phase = expected + step;
            group.push(block);
        } else {
            found.leaps += usize::from(unknown < 0.2);
            found.groups.push(vec![block]);
        }
    }
    // A block in which the leap is has a phase of neither side.
    if found.groups.iter().any(|group| group.len() > 1) {
        found.groups.retain(|group| group.len() > 1);
    }
    found
}

/// The drift of the phases within groups, by least squares.
fn pooled_slope(groups: &[Vec<Block>]) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    for group in groups.iter() {
        let n = group.len() as f64;
        let at = group.iter().map(|block| block.at).sum::<f64>() / n;
        let phase = group.iter().map(|block| block.phase).sum::<f64>() / n;
        product += group.iter().map(|block| (block.at - at) * (block.phase - phase)).sum::<f64>();
        square += group.iter().map(|block| (block.at - at).powi(2)).sum::<f64>();
    }
    if square > 0.0 { product / square } else { 0.0 }
}

/// A phase as one of −0.5 to 0.5.
pub(super) fn wrapped(phase: f64) -> f64 {
    phase - phase.round()
}

/// The middle of some numbers, which are sorted by it.
pub(super) fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or_default()
}

/// Echoes of a block.
const BLOCK: usize = 40;

/// Blocks by which the rate is found.
const MOST_BLOCKS: usize = 60;

/// Blocks on each side that a wandering phase is smoothed over.
const SMOOTH: usize = 2;

/// A block ends at a gap of so many median periods.
const GAP: f64 = 50.0;

/// Clocks differ by no more than this.
const MOST_RATE: f64 = 3e-4;

const MOST_RATES: i64 = 3000;

/// The change of the drift of clocks within a log, at most.
const UNKNOWN_RATE: f64 = 2e-6;

/// Residues that agree less than this may be anything: a jitter of four fifths of a frame.
const LEAST_AGREEMENT: f64 = 0.25;

/// A phase leaps if it changes by more than this, in frames, and five standard errors.
const LEAP: f64 = 0.01;

/// Leaps that a log may have, and one in forty blocks more.
const MOST_LEAPS: usize = 3;

const LISTED: usize = 5;

/// An echo is no farther from the phase than this, when it is decided on which side of a leap it is.
const CLIP: f64 = 0.1;

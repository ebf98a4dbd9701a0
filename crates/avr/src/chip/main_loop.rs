//! The main loop of a program, found while it runs.
//!
//! A program has no mark of its main loop, and an optimiser leaves no function of that name. But a loop is closed by a jump back,
//! and the main loop is the outermost one of them in which the program stays. Loops are distinguished by their head (the target
//! of the jump back) and by the stack pointer at the jump: what a loop calls, and what interrupts it, jumps back at a lower one.
//! Of the loops that were seen those are kept that may be the main one, the outer ones first:
//!
//! - A jump at a higher stack pointer than theirs ends loops: their function has returned.
//! - A jump to the head of a loop ends a round of it, and all loops that were begun in the round.
//! - Another jump makes a new loop. Loops that it encloses are parts of it.
//! - A jump at a lower stack pointer makes a new loop only if the call that it is in was not made in a loop that has come
//!   round: the return address on the stack says that.
//!
//! The main loop is the outermost one that has come round since and was not left for another one beside it. So loops of
//! `setup()` and of the C library's start give way to the main loop as soon as that has come round.

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::Chip;
use super::repeat::JUMP;
use crate::board::Board;
use crate::instruction::{Op, decode};
use crate::part::SRAM_START;
use crate::rounds::{Round, Rounds};

/// Loops that are kept, and of those that were left.
const MOST: usize = 16;
/// The search for the return address of a call goes so far below a loop's stack pointer: arguments may be above it.
const MOST_ARGUMENTS: u16 = 32;
/// Arrivals at heads that are kept to be repeated.
const MOST_ARRIVALS: usize = 512;

/// The loops under watch, if any are. They are no part of the chip's state.
#[derive(Clone, Debug, Default)]
pub(super) struct Watched(pub(super) Option<Box<Loops>>);

/// Chips that do the same are equal.
impl PartialEq for Watched {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// The loops of a program that may be its main loop.
#[derive(Clone, Debug, Default)]
pub(super) struct Loops {
    /// The outer ones first: none has a higher stack pointer than the one before.
    open: Vec<Loop>,
    /// The place of the main loop.
    main: Option<usize>,
    /// Loops that were left: those that took the most time.
    left: Vec<Loop>,
    /// Head and stack pointer of the main loop before the last reset.
    at_reset: Option<(u32, u16)>,
    /// Arrivals at heads since the state was marked with which the repeating state is compared.
    arrivals: Vec<Arrival>,
    /// The period in which this began, and how many there were in sleep.
    since: u64,
    asleep: u64,
}

#[derive(Clone, Debug)]
struct Loop {
    head: u32,
    /// The last instruction that is known of it.
    end: u32,
    sp: u16,
    /// The last arrival at its head, in periods.
    since: u64,
    /// The place on the stack of its last call's return address.
    called_at: u16,
    rounds: Rounds,
}

/// An arrival at the head of a loop.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    head: u32,
    sp: u16,
    at: u64,
}

/// A jump back.
#[derive(Clone, Copy, Debug)]
struct Jump {
    from: u32,
    to: u32,
    sp: u16,
    /// In periods.
    at: u64,
}

/// The memory in which a return address on the stack is looked for.
struct Memory<'a> {
    sram: &'a [u8],
    flash: &'a [u16],
}

impl Loops {
    /// A jump back was made. If a round of the main loop begins, gives the one before it.
    fn jump(&mut self, jump: Jump, memory: &Memory<'_>) -> Option<Round> {
        while self.open.last().is_some_and(|open| open.sp < jump.sp) {
            self.close_from(self.open.len() - 1);
        }
        if let Some(place) = self.open.iter().rposition(|open| open.sp == jump.sp && open.head == jump.to) {
            self.close_from(place + 1);
            let open = &mut self.open[place];
            let is_first = open.rounds.count() == 0;
            if is_first {
                open.end = memory.last_jump_to(open.head, open.end);
            }
            let last = open.arrive(jump.at);
            if is_first || jump.from > open.end {
                open.end = open.end.max(jump.from);
                self.find_main();
            }
            return (self.main == Some(place)).then_some(last);
        }
        if !self.is_part_of_main(jump, memory) {
            self.open_loop(jump);
        }
        None
    }

    /// Whether a jump is within the main loop, or in what that calls, or interrupts it.
    fn is_part_of_main(&mut self, jump: Jump, memory: &Memory<'_>) -> bool {
        if self.open.last().is_some_and(|open| open.sp > jump.sp) {
            let mut came_round = self.open.iter_mut().rev().filter(|open| open.rounds.count() > 0);
            return came_round.any(|open| open.has_called(jump.sp, memory));
        }
        for place in 0..self.open.len() {
            let open = &mut self.open[place];
            // Code that is needed rarely may lie behind the loop, and jumps back into it.
            if open.sp == jump.sp && (open.head..=open.end).contains(&jump.to) && jump.from > open.end {
                open.end = jump.from;
                self.find_main();
            }
        }
        let Some(main) = self.main.map(|main| &self.open[main]) else { return false };
        main.sp == jump.sp && main.head < jump.to && jump.from <= main.end
    }

    fn open_loop(&mut self, jump: Jump) {
        let Jump { from, to, sp, at } = jump;
        let mut end = from;
        for place in (0..self.open.len()).rev() {
            let open = &self.open[place];
            if open.sp == sp && (to..=from).contains(&open.head) {
                end = end.max(open.end);
                self.close(place);
            }
        }
        if self.open.len() == MOST {
            self.close(0);
        }
        let known = self.left.iter().position(|left| left.head == to && left.sp == sp);
        let rounds = known.map_or_else(|| Rounds::new(to), |known| self.left.remove(known).rounds);
        self.open.push(Loop { head: to, end, sp, since: at, called_at: sp, rounds });
        self.find_main();
    }

    fn close_from(&mut self, place: usize) {
        while self.open.len() > place {
            self.close(self.open.len() - 1);
        }
    }

    fn close(&mut self, place: usize) {
        let closed = self.open.remove(place);
        self.find_main();
        if closed.rounds.count() == 0 {
            return;
        }
        self.left.push(closed);
        if self.left.len() > MOST {
            // A main loop takes the most time of all.
            let shortest = self.left.iter().enumerate().min_by_key(|(_, left)| left.rounds.total());
            if let Some(place) = shortest.map(|(place, _)| place) {
                self.left.remove(place);
            }
        }
    }

    /// The main loop may be another now.
    fn find_main(&mut self) {
        let is_main = |place: &usize| {
            let (open, inner) = (&self.open[*place], &self.open[place + 1..]);
            let is_within =
                |inner: &Loop| inner.sp == open.sp && inner.head >= open.head && inner.end <= open.end;
            open.rounds.count() > 0 && inner.iter().all(is_within)
        };
        self.main = (0..self.open.len()).find(is_main);
    }

    /// The main loop, or the one before the last reset if that took more time.
    fn found(&self) -> Option<&Loop> {
        let main = self.main.map(|main| &self.open[main]);
        let before = self.at_reset.and_then(|at| self.left.iter().find(|left| (left.head, left.sp) == at));
        main.into_iter().chain(before).max_by_key(|found| found.rounds.total())
    }

    /// Repeats the arrivals since the beginning so many times, each time after so many periods. Gives each round of
    /// the main loop that begins to `begins`, with the one before it.
    fn repeat(&mut self, period: u64, times: u64, mut begins: impl FnMut(u64, Round)) {
        for (place, open) in self.open.iter_mut().enumerate() {
            let of_it = |arrival: &&Arrival| arrival.head == open.head && arrival.sp == open.sp;
            let at: Vec<u64> = self.arrivals.iter().filter(of_it).map(|arrival| arrival.at).collect();
            let (Some(&first), Some(&last)) = (at.first(), at.last()) else { continue };
            let between = at.windows(2).map(|pair| pair[1] - pair[0]);
            let lengths: Vec<u64> = core::iter::once(first + period - last).chain(between).collect();
            lengths.iter().for_each(|length| open.rounds.add(*length, times));
            open.since = last + period * times;
            if self.main == Some(place) {
                let round = |cycles: &u64| Round { head: open.head, cycles: *cycles };
                let all = at.iter().zip(lengths.iter().map(round));
                (1..=times)
                    .for_each(|time| all.clone().for_each(|(at, last)| begins(at + time * period, last)));
            }
        }
    }
}

impl Loop {
    /// Gives the round that is over.
    fn arrive(&mut self, at: u64) -> Round {
        let cycles = at.saturating_sub(self.since);
        self.rounds.add(cycles, 1);
        self.since = at;
        Round { head: self.head, cycles }
    }

    /// Whether calls or interrupts in the loop have this lower stack pointer: a return address below the loop's stack
    /// pointer shows it. Right at the stack pointer is that of a call elsewhere, or arguments are, and the address is
    /// below them.
    fn has_called(&mut self, sp: u16, memory: &Memory<'_>) -> bool {
        let lowest = sp.max(self.sp.saturating_sub(MOST_ARGUMENTS)).saturating_add(2);
        let (head, end) = (self.head, self.end);
        let is_here = |low: &u16| (head..=end).contains(&memory.address(*low));
        if self.called_at >= lowest && is_here(&self.called_at) {
            return true;
        }
        if !is_here(&self.sp) && memory.is_behind_call(memory.address(self.sp)) {
            return false;
        }
        let found = (lowest..=self.sp).rev().find(is_here);
        self.called_at = found.unwrap_or(self.called_at);
        found.is_some()
    }
}

impl Memory<'_> {
    /// A return address on the stack, by the place of its lower byte.
    fn address(&self, low: u16) -> u32 {
        let place = usize::from(low.wrapping_sub(SRAM_START));
        match self.sram.get(place.wrapping_sub(1)..=place) {
            Some(&[high, low]) => u32::from(high) << 8 | u32::from(low),
            Some(_) | None => 0,
        }
    }

    /// The last jump or branch back to an address, if it is behind another: what is seldom done in a loop may have a jump of its own.
    fn last_jump_to(&self, head: u32, other: u32) -> u32 {
        let word = |at: u32| self.flash.get(at as usize).copied().unwrap_or(0xFFFF);
        let is_jump = |at: &u32| jumped_to(*at, decode(word(*at), word(at + 1))) == Some(head);
        (other + 1..self.flash.len() as u32).rev().find(is_jump).unwrap_or(other)
    }

    fn is_behind_call(&self, address: u32) -> bool {
        let word = |back: u32| {
            let at = address.checked_sub(back)?;
            self.flash.get(at as usize).copied()
        };
        let is_near = |word: u16| word & 0xF000 == RCALL || word == ICALL;
        word(1).is_some_and(is_near) || word(2).is_some_and(|word| word & 0xFE0E == CALL)
    }
}

/// The target of a jump at an address.
#[expect(clippy::wildcard_enum_match_arm, reason = "of all instructions only jumps close a loop")]
fn jumped_to(at: u32, op: Op) -> Option<u32> {
    match op {
        Op::Rjmp { offset } => (at + 1).checked_add_signed(offset.into()),
        Op::Brbs { offset, .. } | Op::Brbc { offset, .. } => (at + 1).checked_add_signed(offset.into()),
        Op::Jmp { high, low } => Some(u32::from(high) << 16 | u32::from(low)),
        _ => None,
    }
}

/// *AVR Instruction Set Manual*: without the bits of the address.
const RCALL: u16 = 0xD000;
const ICALL: u16 = 0x9509;
const CALL: u16 = 0x940E;

impl Chip {
    /// Watches the duration of the rounds of the program's main loop from now on, or no longer does, and forgets the
    /// earlier ones.
    ///
    /// The main loop is the outermost loop in which the program stays: of `loop()` of an Arduino's sketch, whether or not it
    /// is a function of its own, and of `for (;;)` in a program in C. A round is from one arrival of the program counter at
    /// its head to the next. What interrupts it, what it calls and its sleep belong to the round. The first rounds are found when
    /// the program has come to the head a second time; before that, loops before the main loop count as such.
    ///
    /// Loops are closed by `RJMP`, `JMP` and branches to a lower address. A loop that is closed by `IJMP`, by a call or by a
    /// reset is not seen, nor is one that counts two or three registers down and does nothing else. A program that changes
    /// between several stacks has no main loop in this sense; one that goes on for good in an inner loop has the outer one,
    /// which does not come round any more. Of a waiting loop at the beginning of the main one (`while (!flag) {}`), whose head is the
    /// same, each round counts.
    ///
    /// Nothing else changes by it: it is not in what is saved, and chips with and without it are equal and go on alike. A chip
    /// that is loaded watches nothing.
    pub fn watch_rounds(&mut self, watch: bool) {
        let since = self.now();
        self.watched.0 = watch.then(|| Box::new(Loops { since, ..Loops::default() }));
    }

    /// Whether rounds are [watched](Self::watch_rounds).
    pub const fn watches_rounds(&self) -> bool {
        self.watched.0.is_some()
    }

    /// Rounds of the main loop since they are [watched](Self::watch_rounds). Behind a reset it is the one before it, until the
    /// program has been longer in another. None if none was found.
    pub fn rounds(&self) -> Option<&Rounds> {
        Some(&self.watched.0.as_deref()?.found()?.rounds)
    }

    /// The share of the time in which the processor slept, since rounds are [watched](Self::watch_rounds); None if they are not.
    pub fn share_asleep(&self) -> Option<f64> {
        let loops = self.watched.0.as_deref()?;
        let all = self.now().saturating_sub(loops.since);
        (all > 0).then(|| loops.asleep as f64 / all as f64)
    }

    /// A jump back was made by the instruction before this address, and ends with this cycle.
    pub(super) fn watch_jump<B: Board>(&mut self, behind: u32, now: u64, board: &mut B) {
        let Some(loops) = &mut self.watched.0 else { return };
        let from = behind.wrapping_sub(1) & self.pc_mask;
        let (to, sp, at) = (self.pc, self.sp, self.clock.period_of(now));
        if to > from {
            // The jump goes round the end of the memory.
            return;
        }
        let memory = Memory { sram: &self.sram, flash: self.flash.words() };
        if let Some(last) = loops.jump(Jump { from, to, sp, at }, &memory) {
            board.round_begins(at, last);
        }
        if self.repeat.is_looking() {
            if loops.arrivals.len() < MOST_ARRIVALS {
                loops.arrivals.push(Arrival { head: to, sp, at });
            } else {
                self.repeat.give_up();
            }
        }
    }

    /// Arrivals that are repeated from now on begin anew.
    pub(super) fn forget_arrivals(&mut self) {
        if let Some(loops) = &mut self.watched.0 {
            loops.arrivals.clear();
        }
    }

    /// The work of the last cycles up to this one is done so many times more.
    pub(super) fn watch_repeats<B: Board>(&mut self, now: u64, cycles: u64, times: u64, board: &mut B) {
        let Some(loops) = &mut self.watched.0 else { return };
        let period = self.clock.period_of(now + cycles) - self.clock.period_of(now);
        loops.repeat(period, times, |at, last| board.round_begins(at, last));
    }

    /// A loop that waits has jumped back, and goes on for so many cycles more.
    #[inline(never)]
    pub(super) fn watch_wait<B: Board>(&mut self, behind: u32, length: u64, passed: u64, board: &mut B) {
        let now = self.cycle + JUMP;
        self.watch_jump(behind, now, board);
        if passed < length {
            return;
        }
        self.forget_arrivals();
        if let Some(loops) = &mut self.watched.0 {
            loops.arrivals.push(Arrival { head: self.pc, sp: self.sp, at: self.clock.period_of(now) });
        }
        self.watch_repeats(now, length, passed / length, board);
    }

    /// The processor has slept since this period.
    pub(super) fn watch_sleep(&mut self, since: u64) {
        let now = self.now();
        if let Some(loops) = &mut self.watched.0 {
            loops.asleep += now.saturating_sub(since);
        }
    }

    /// The program begins anew.
    pub(super) fn watch_reset(&mut self) {
        let Some(loops) = &mut self.watched.0 else { return };
        loops.at_reset = loops.found().map(|found| (found.head, found.sp));
        loops.close_from(0);
    }
}

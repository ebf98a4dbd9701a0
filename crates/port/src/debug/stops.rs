//! The places at which the chip stops.

use std::ops::Range;

use baudbot_avr::Chip;
use gdbstub::common::Signal;
use gdbstub::stub::SingleThreadStopReason;
use gdbstub::target::ext::breakpoints::WatchKind;

/// The reason of a stop, as GDB knows it.
pub(crate) type Reason = SingleThreadStopReason<u32>;

/// The way in which the chip is to run on.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum Run {
    /// The chip runs until something stops it.
    #[default]
    Continue,
    /// The chip runs until the next instruction is beyond these byte addresses.
    While(Range<u32>),
}

/// Breakpoints and watchpoints, and how the chip runs.
#[derive(Debug, Default)]
pub(crate) struct Stops {
    /// Byte addresses; one that was set twice is here twice.
    software: Vec<u32>,
    hardware: Vec<u32>,
    watches: Vec<Watch>,
    run: Run,
    /// Whether an instruction has been executed since the chip runs.
    has_run: bool,
    reason: Option<Reason>,
}

#[derive(Debug)]
struct Watch {
    /// The address as GDB encodes it.
    address: u32,
    places: Range<usize>,
    value: Vec<u8>,
}

impl Stops {
    pub(crate) fn software(&mut self) -> &mut Vec<u32> {
        &mut self.software
    }

    pub(crate) fn hardware(&mut self) -> &mut Vec<u32> {
        &mut self.hardware
    }

    /// Stops behind an instruction that changes the bytes at these places of the static memory.
    pub(crate) fn watch(&mut self, address: u32, places: Range<usize>) {
        self.watches.push(Watch { address, places, value: Vec::new() });
    }

    /// The number of watchpoints.
    pub(crate) fn watches(&self) -> usize {
        self.watches.len()
    }

    /// Whether there was such a watchpoint.
    pub(crate) fn unwatch(&mut self, address: u32, places: &Range<usize>) -> bool {
        let same = |watch: &Watch| watch.address == address && watch.places == *places;
        self.watches.iter().position(same).map(|at| self.watches.remove(at)).is_some()
    }

    /// The chip runs on from here.
    pub(crate) fn run(&mut self, run: Run, chip: &Chip) {
        (self.run, self.has_run, self.reason) = (run, false, None);
        for watch in &mut self.watches {
            watch.value = chip.sram()[watch.places.clone()].to_vec();
        }
    }

    /// Whether the chip is to stop before the instruction that comes next. GDB itself steps over a breakpoint at which the chip
    /// stands before it lets the chip run on.
    #[inline]
    pub(crate) fn stops(&mut self, chip: &Chip) -> bool {
        let is_first = !std::mem::replace(&mut self.has_run, true);
        self.reason = self.reason_at(chip, is_first);
        self.reason.is_some()
    }

    fn reason_at(&self, chip: &Chip, is_first: bool) -> Option<Reason> {
        let changed = |watch: &&Watch| chip.sram()[watch.places.clone()] != *watch.value;
        if let Some(watch) = self.watches.iter().find(changed) {
            return Some(Reason::Watch { tid: (), kind: WatchKind::Write, addr: watch.address });
        }
        let pc = chip.pc() * 2;
        let steps = match &self.run {
            Run::Continue => false,
            Run::While(_) if is_first => return None,
            Run::While(range) => !range.contains(&pc),
        };
        if self.software.contains(&pc) {
            Some(Reason::SwBreak(()))
        } else if self.hardware.contains(&pc) {
            Some(Reason::HwBreak(()))
        } else {
            steps.then_some(Reason::DoneStep)
        }
    }

    /// The reason of the stop: a `BREAK` if nothing else is known.
    pub(crate) fn reason(&mut self) -> Reason {
        self.reason.take().unwrap_or(Reason::Signal(Signal::SIGTRAP))
    }
}

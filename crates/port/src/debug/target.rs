//! A board as the protocol's crate wants it.

use std::convert::Infallible;

use baudbot_board::Board;
use gdbstub::common::Signal;
use gdbstub::target::ext::base::BaseOps;
use gdbstub::target::ext::base::single_register_access::{SingleRegisterAccess, SingleRegisterAccessOps};
use gdbstub::target::ext::base::singlethread::{
    SingleThreadBase, SingleThreadRangeStepping, SingleThreadRangeSteppingOps, SingleThreadResume,
    SingleThreadResumeOps, SingleThreadSingleStep, SingleThreadSingleStepOps,
};
use gdbstub::target::ext::breakpoints::{
    Breakpoints, BreakpointsOps, HwBreakpoint, HwBreakpointOps, HwWatchpoint, HwWatchpointOps, SwBreakpoint,
    SwBreakpointOps, WatchKind,
};
use gdbstub::target::ext::monitor_cmd::MonitorCmdOps;
use gdbstub::target::{Target, TargetError, TargetResult};

use super::arch::{Avr, AvrRegister, AvrRegisters};
use super::memory;
use super::stops::{Run, Stops};

/// The board that is looked at, and where its chip stops.
pub(crate) struct ChipTarget {
    /// The board; between two looks, any.
    pub(crate) board: Board,
    pub(crate) stops: Stops,
}

impl Target for ChipTarget {
    type Arch = Avr;
    type Error = Infallible;

    fn base_ops(&mut self) -> BaseOps<'_, Avr, Infallible> {
        BaseOps::SingleThread(self)
    }

    fn support_breakpoints(&mut self) -> Option<BreakpointsOps<'_, Self>> {
        Some(self)
    }

    fn support_monitor_cmd(&mut self) -> Option<MonitorCmdOps<'_, Self>> {
        Some(self)
    }
}

impl SingleThreadBase for ChipTarget {
    fn read_registers(&mut self, registers: &mut AvrRegisters) -> TargetResult<(), Self> {
        let chip = self.board.chip();
        *registers = AvrRegisters {
            general: *chip.general_registers(),
            sreg: chip.status_register(),
            sp: chip.stack_pointer(),
            pc: chip.pc() * 2,
        };
        Ok(())
    }

    fn write_registers(&mut self, registers: &AvrRegisters) -> TargetResult<(), Self> {
        let chip = self.board.chip_mut();
        *chip.general_registers_mut() = registers.general;
        chip.set_status_register(registers.sreg);
        chip.set_stack_pointer(registers.sp);
        chip.set_pc(registers.pc / 2);
        Ok(())
    }

    fn support_single_register_access(&mut self) -> Option<SingleRegisterAccessOps<'_, (), Self>> {
        Some(self)
    }

    fn read_addrs(&mut self, address: u32, bytes: &mut [u8]) -> TargetResult<usize, Self> {
        memory::read(&self.board, address, bytes).ok_or(TargetError::Errno(BAD_ADDRESS))
    }

    fn write_addrs(&mut self, address: u32, bytes: &[u8]) -> TargetResult<(), Self> {
        memory::write(&mut self.board, address, bytes).ok_or(TargetError::Errno(BAD_ADDRESS))
    }

    fn support_resume(&mut self) -> Option<SingleThreadResumeOps<'_, Self>> {
        Some(self)
    }
}

impl SingleRegisterAccess<()> for ChipTarget {
    fn read_register(
        &mut self,
        (): (),
        register: AvrRegister,
        bytes: &mut [u8],
    ) -> TargetResult<usize, Self> {
        let chip = self.board.chip();
        let value = match register {
            AvrRegister::General(number) => chip.general_registers()[usize::from(number)].into(),
            AvrRegister::Sreg => chip.status_register().into(),
            AvrRegister::Sp => chip.stack_pointer().into(),
            AvrRegister::Pc => chip.pc() * 2,
        };
        let count = bytes.len().min(4);
        bytes[..count].copy_from_slice(&value.to_le_bytes()[..count]);
        Ok(count)
    }

    fn write_register(&mut self, (): (), register: AvrRegister, bytes: &[u8]) -> TargetResult<(), Self> {
        let chip = self.board.chip_mut();
        match (register, bytes) {
            (AvrRegister::General(number), &[value]) => {
                chip.general_registers_mut()[usize::from(number)] = value;
            }
            (AvrRegister::Sreg, &[value]) => chip.set_status_register(value),
            (AvrRegister::Sp, &[low, high]) => chip.set_stack_pointer(u16::from_le_bytes([low, high])),
            (AvrRegister::Pc, &[a, b, c, d]) => chip.set_pc(u32::from_le_bytes([a, b, c, d]) / 2),
            (AvrRegister::General(_) | AvrRegister::Sreg | AvrRegister::Sp | AvrRegister::Pc, _) => {
                return Err(TargetError::NonFatal);
            }
        }
        Ok(())
    }
}

impl SingleThreadResume for ChipTarget {
    fn resume(&mut self, _signal: Option<Signal>) -> Result<(), Infallible> {
        self.stops.run(Run::Continue, self.board.chip());
        Ok(())
    }

    fn support_single_step(&mut self) -> Option<SingleThreadSingleStepOps<'_, Self>> {
        Some(self)
    }

    fn support_range_step(&mut self) -> Option<SingleThreadRangeSteppingOps<'_, Self>> {
        Some(self)
    }
}

impl SingleThreadSingleStep for ChipTarget {
    fn step(&mut self, _signal: Option<Signal>) -> Result<(), Infallible> {
        self.resume_range_step(0, 0)
    }
}

impl SingleThreadRangeStepping for ChipTarget {
    fn resume_range_step(&mut self, start: u32, end: u32) -> Result<(), Infallible> {
        self.stops.run(Run::While(start..end), self.board.chip());
        Ok(())
    }
}

impl Breakpoints for ChipTarget {
    fn support_sw_breakpoint(&mut self) -> Option<SwBreakpointOps<'_, Self>> {
        Some(self)
    }

    fn support_hw_breakpoint(&mut self) -> Option<HwBreakpointOps<'_, Self>> {
        Some(self)
    }

    fn support_hw_watchpoint(&mut self) -> Option<HwWatchpointOps<'_, Self>> {
        Some(self)
    }
}

impl SwBreakpoint for ChipTarget {
    fn add_sw_breakpoint(&mut self, address: u32, _kind: usize) -> TargetResult<bool, Self> {
        Ok(add(&self.board, self.stops.software(), address))
    }

    fn remove_sw_breakpoint(&mut self, address: u32, _kind: usize) -> TargetResult<bool, Self> {
        Ok(remove(self.stops.software(), address))
    }
}

impl HwBreakpoint for ChipTarget {
    fn add_hw_breakpoint(&mut self, address: u32, _kind: usize) -> TargetResult<bool, Self> {
        Ok(add(&self.board, self.stops.hardware(), address))
    }

    fn remove_hw_breakpoint(&mut self, address: u32, _kind: usize) -> TargetResult<bool, Self> {
        Ok(remove(self.stops.hardware(), address))
    }
}

impl HwWatchpoint for ChipTarget {
    fn add_hw_watchpoint(&mut self, address: u32, len: u32, kind: WatchKind) -> TargetResult<bool, Self> {
        let places = memory::sram(&self.board, address, len).filter(|_| kind == WatchKind::Write);
        let Some(places) = places.filter(|_| self.stops.watches() < MOST) else { return Ok(false) };
        self.stops.watch(address, places);
        Ok(true)
    }

    fn remove_hw_watchpoint(&mut self, address: u32, len: u32, _kind: WatchKind) -> TargetResult<bool, Self> {
        let places = memory::sram(&self.board, address, len);
        Ok(places.is_some_and(|places| self.stops.unwatch(address, &places)))
    }
}

/// Whether a breakpoint has a place there.
fn add(board: &Board, breakpoints: &mut Vec<u32>, address: u32) -> bool {
    let is_code = address.is_multiple_of(2) && (address / 2) < board.chip().flash().len() as u32;
    let fits = is_code && breakpoints.len() < MOST;
    if fits {
        breakpoints.push(address);
    }
    fits
}

/// Whether there was such a breakpoint.
fn remove(breakpoints: &mut Vec<u32>, address: u32) -> bool {
    breakpoints.iter().position(|&at| at == address).map(|at| breakpoints.swap_remove(at)).is_some()
}

/// `EFAULT` by the protocol's numbers.
const BAD_ADDRESS: u8 = 14;

/// Breakpoints of a kind, and watchpoints.
const MOST: usize = 1000;

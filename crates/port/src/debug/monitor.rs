//! The commands behind `monitor`.

use std::convert::Infallible;

use gdbstub::outputln;
use gdbstub::target::ext::monitor_cmd::{ConsoleOutput, MonitorCmd};

use super::target::ChipTarget;

impl MonitorCmd for ChipTarget {
    fn handle_monitor_cmd(&mut self, command: &[u8], mut out: ConsoleOutput<'_>) -> Result<(), Infallible> {
        match command.trim_ascii() {
            b"reset" => {
                self.board.reset();
                outputln!(out, "The chip is reset.");
            }
            b"time" => {
                let (chip, clock) = (self.board.chip(), self.board.clock());
                let at_s = clock.ns(chip.now()) as f64 * 1e-9;
                outputln!(
                    out,
                    "{at_s:.9} s after the chip's supply came on, {} cycles of its clock",
                    chip.cycles()
                );
            }
            _ => outputln!(
                out,
                "monitor reset: resets the chip by its pin RESET\nmonitor time: the time for which it has run"
            ),
        }
        Ok(())
    }
}

//! The protocol, from the first byte to the last.

use std::convert::Infallible;
use std::io;

use gdbstub::common::Signal;
use gdbstub::conn::Connection;
use gdbstub::stub::state_machine::GdbStubStateMachine;
use gdbstub::stub::{GdbStubBuilder, GdbStubError};

use super::stops::Reason;
use super::target::ChipTarget;
use super::wire::Wire;

type Machine = GdbStubStateMachine<'static, ChipTarget, Wire>;
type Error = GdbStubError<Infallible, io::Error>;

/// A debugger that is connected. It holds the chip at first.
pub(crate) struct Session {
    /// `None` once the debugger has released the chip.
    machine: Option<Machine>,
}

impl Session {
    pub(crate) fn new(wire: Wire, target: &mut ChipTarget) -> Self {
        let stub = GdbStubBuilder::new(wire).packet_buffer_size(PACKET_BYTES).build();
        let stub = stub.expect("a builder with a size has a buffer");
        let mut session = Self { machine: None };
        session.keep(stub.run_state_machine(target));
        session
    }

    /// Whether the debugger has released the chip.
    pub(crate) fn is_over(&self) -> bool {
        self.machine.is_none()
    }

    /// Obeys the debugger while it holds the chip, unless it is time to give up.
    pub(crate) fn hold(&mut self, target: &mut ChipTarget, gives_up: &dyn Fn() -> bool) {
        while let Some(Machine::Idle(idle)) = &mut self.machine {
            if gives_up() {
                self.machine = None;
                return;
            }
            let mut bytes = [0; 1024];
            let read = idle.borrow_conn().wait(&mut bytes);
            self.hear(read, &bytes, target);
        }
    }

    /// Reads from a debugger while the chip runs: Ctrl-C.
    pub(crate) fn poll(&mut self, target: &mut ChipTarget) {
        if let Some(Machine::Running(running)) = &mut self.machine {
            let mut bytes = [0; 1024];
            let read = running.borrow_conn().poll(&mut bytes);
            self.hear(read, &bytes, target);
        }
    }

    fn hear(&mut self, read: io::Result<usize>, bytes: &[u8], target: &mut ChipTarget) {
        match read {
            Ok(count) => {
                bytes[..count].iter().for_each(|&byte| self.feed(byte, target));
                self.flush();
            }
            Err(error) => {
                tracing::info!(%error, "a debugger has disconnected");
                self.machine = None;
            }
        }
    }

    /// Sends the rest that no answer has taken along: the confirmation of a command to run.
    fn flush(&mut self) {
        let wire = match &mut self.machine {
            Some(Machine::Idle(idle)) => idle.borrow_conn(),
            Some(Machine::Running(running)) => running.borrow_conn(),
            Some(Machine::CtrlCInterrupt(_) | Machine::Disconnected(_)) | None => return,
        };
        if wire.flush().is_err() {
            self.machine = None;
        }
    }

    /// The chip has stopped.
    pub(crate) fn report(&mut self, reason: Reason, target: &mut ChipTarget) {
        if let Some(machine) = self.machine.take() {
            self.keep(match machine {
                Machine::Running(running) => running.report_stop(target, reason),
                other @ (Machine::Idle(_) | Machine::CtrlCInterrupt(_) | Machine::Disconnected(_)) => {
                    Ok(other)
                }
            });
        }
    }

    fn feed(&mut self, byte: u8, target: &mut ChipTarget) {
        let Some(machine) = self.machine.take() else { return };
        let next = match machine {
            Machine::Idle(idle) => idle.incoming_data(target, byte),
            Machine::Running(running) => running.incoming_data(target, byte),
            other @ (Machine::CtrlCInterrupt(_) | Machine::Disconnected(_)) => Ok(other),
        };
        self.keep(match next {
            Ok(Machine::CtrlCInterrupt(interrupt)) => {
                interrupt.interrupt_handled(target, Some(Reason::Signal(Signal::SIGINT)))
            }
            next => next,
        });
    }

    fn keep(&mut self, next: Result<Machine, Error>) {
        self.machine = match next {
            Ok(Machine::Disconnected(mut gone)) => {
                // The debugger may not be there any more.
                let _ = gone.borrow_conn().flush();
                tracing::info!(reason = ?gone.get_reason(), "a debugger has detached");
                None
            }
            Ok(machine) => Some(machine),
            Err(error) => {
                tracing::warn!(%error, "the connection to a debugger is closed");
                None
            }
        };
    }
}

/// The longest packet.
const PACKET_BYTES: usize = 4096;

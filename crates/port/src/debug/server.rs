//! The port at which a debugger connects.

use std::mem;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use std::{io, thread};

use baudbot_access::peer::Reach;
use baudbot_avr::{Chip, Stop};
use baudbot_board::{Board, Debugger, Physics};
use baudbot_sim::chip::Probe;

use super::session::Session;
use super::stops::{Reason, Stops};
use super::target::ChipTarget;
use super::wire::Wire;

/// Debuggers of a chip, one after the other. The first one is waited for.
pub struct GdbServer {
    listener: TcpListener,
    address: SocketAddr,
    reach: Reach,
    gives_up: Box<dyn Fn() -> bool + Send + Sync>,
    state: Mutex<State>,
}

struct State {
    /// Whether there has been a debugger, or none is waited for any more.
    is_known: bool,
    attached: Option<Box<Attached>>,
    /// The instant at which a debugger was last listened to.
    heard: Option<Instant>,
}

struct Attached {
    session: Session,
    target: ChipTarget,
}

impl GdbServer {
    /// Listens at a port of this machine; 0 is any free one. A debugger reads and writes the chip as it likes, and
    /// knows no token: `reach` says whose program may be one. Others are disconnected without a message.
    ///
    /// `gives_up` is asked again and again while the world stands: once it says so, the world goes on without a debugger, and
    /// slowly, so that it can be ended before much has happened.
    ///
    /// # Errors
    /// A port that is taken.
    pub fn listen(
        port: u16,
        reach: Reach,
        gives_up: impl Fn() -> bool + Send + Sync + 'static,
    ) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let state = State { is_known: false, attached: None, heard: None };
        Ok(Self { listener, address, reach, gives_up: Box::new(gives_up), state: state.into() })
    }

    /// The address at which it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// A debugger that connects, or that connects now if one was here before.
    fn accept(&self, is_known: bool) -> Option<Wire> {
        loop {
            match self.listener.accept() {
                Ok((stream, _)) if !self.reach.allows(&stream) => {
                    tracing::warn!(
                        "a program of another user has connected to the debugger's port, and is disconnected"
                    );
                    continue;
                }
                Ok((stream, _)) => match Wire::new(stream) {
                    Ok(wire) => return Some(wire),
                    Err(error) => tracing::warn!(%error, "a debugger cannot connect"),
                },
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) => tracing::warn!(%error, "a debugger cannot connect"),
            }
            if is_known || (self.gives_up)() {
                return None;
            }
            thread::sleep(PAUSE);
        }
    }

    /// Accepts a debugger, or reads from the one that is connected, each so often.
    fn listen_to(&self, state: &mut State, board: &mut Board) {
        if state.heard.is_some_and(|heard| heard.elapsed() < EVERY) {
            return;
        }
        if state.attached.is_none() {
            let wire = self.accept(mem::replace(&mut state.is_known, true));
            state.attached = wire.map(|wire| Box::new(Attached::new(wire, board)));
        }
        if let Some(attached) = &mut state.attached {
            attached.look(board, |session, target| {
                session.poll(target);
                session.hold(target, &self.gives_up);
            });
        }
        state.heard = Some(Instant::now());
        if (self.gives_up)() {
            // The world is to be found where it stood when the program ends, and not at its end.
            thread::sleep(PAUSE);
            state.heard = None;
        }
    }
}

impl Probe for GdbServer {
    fn run(&self, board: &mut Board, until_ns: u64, mut physics: &mut dyn Physics) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        self.listen_to(&mut state, board);
        if let Some(attached) = &mut state.attached {
            board.debug_until(until_ns, &mut physics, &mut Holder { attached, gives_up: &self.gives_up });
        } else {
            board.run_until(until_ns, &mut physics);
        }
        if state.attached.as_ref().is_some_and(|attached| attached.session.is_over()) {
            state.attached = None;
        }
    }
}

impl Drop for GdbServer {
    /// The world is over: so is the program, to who debugs it.
    fn drop(&mut self) {
        let state = self.state.get_mut().unwrap_or_else(PoisonError::into_inner);
        if let Some(attached) = &mut state.attached {
            attached.session.report(Reason::Exited(0), &mut attached.target);
        }
    }
}

impl Attached {
    fn new(wire: Wire, board: &Board) -> Self {
        let mut target = ChipTarget { board: board.clone(), stops: Stops::default() };
        Self { session: Session::new(wire, &mut target), target }
    }

    /// Lets the debugger look at a board.
    fn look(&mut self, board: &mut Board, look: impl FnOnce(&mut Session, &mut ChipTarget)) {
        mem::swap(board, &mut self.target.board);
        look(&mut self.session, &mut self.target);
        mem::swap(board, &mut self.target.board);
    }
}

/// The debugger while the chip runs.
struct Holder<'a> {
    attached: &'a mut Attached,
    gives_up: &'a dyn Fn() -> bool,
}

impl Debugger for Holder<'_> {
    fn stops(&mut self, chip: &Chip) -> bool {
        !self.attached.session.is_over() && self.attached.target.stops.stops(chip)
    }

    fn stopped(&mut self, board: &mut Board, _why: Stop) {
        let gives_up = self.gives_up;
        self.attached.look(board, |session, target| {
            let reason = target.stops.reason();
            session.report(reason, target);
            session.hold(target, gives_up);
        });
    }
}

/// The interval at which a debugger is listened to while the chip runs.
const EVERY: Duration = Duration::from_millis(2);

/// The interval at which new connections are looked for.
const PAUSE: Duration = Duration::from_millis(10);

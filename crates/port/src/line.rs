//! The handle of a port's thread for the rest of the program.

use std::collections::VecDeque;
use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;

use baudbot_fields::endpoint::Endpoint;
use rustix::event::{EventfdFlags, eventfd};
use tokio::sync::mpsc::UnboundedSender;

use crate::cable::Cable;
use crate::driver::{Driver, Order, Told};
use crate::error::PortError;
use crate::hold::Hold;
use crate::medium::Medium;
use crate::report::Report;
use baudbot_access::peer::Reach;
use baudbot_board::far_end::Settings;

/// A port that is open for programs.
#[derive(Debug)]
pub(crate) struct Line {
    /// The sensor's place in the robot's description whose own cable it is; none for the microcontroller's.
    pub(crate) sensor: Option<u32>,
    /// The place at which programs find it.
    pub(crate) place: String,
    orders: Sender<Order>,
    wake: OwnedFd,
    held: Arc<AtomicUsize>,
    thread: Option<JoinHandle<Report>>,
}

impl Line {
    /// Opens a port at a place, at a cable whose UART at the robot's end is set so, if it has one. `number` goes with
    /// all events.
    pub(crate) fn open(
        (sensor, place, reach): (Option<u32>, &Endpoint, Reach),
        hold: Hold,
        settings: Option<Settings>,
        step_ns: u64,
        (number, told): (usize, UnboundedSender<(usize, Told)>),
    ) -> Result<Self, PortError> {
        let medium = Medium::open(place, reach, settings.as_ref())?;
        let failed = |source: io::Error| PortError::Open { place: place.clone(), source };
        let where_it_is = medium.where_it_is(place);
        let wake = eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)
            .map_err(|error| failed(error.into()))?;
        let (orders, received) = channel();
        let held = Arc::new(AtomicUsize::new(0));
        let driver = Driver {
            medium,
            hold,
            cable: Cable::new(settings),
            step_ns,
            orders: received,
            wake: wake.try_clone().map_err(failed)?,
            told: (number, told),
            clock: None,
            waiting: VecDeque::new(),
            sending: VecDeque::new(),
            report: Report::default(),
            held: Arc::clone(&held),
            break_since_ns: None,
        };
        let thread = std::thread::Builder::new()
            .name("serial port".to_owned())
            .spawn(|| driver.serve())
            .map_err(failed)?;
        Ok(Self { sensor, place: where_it_is, orders, wake, held, thread: Some(thread) })
    }

    /// Sends the thread an order.
    pub(crate) fn order(&self, order: Order) {
        // Both fail only when the thread is gone.
        drop(self.orders.send(order));
        let _ = rustix::io::write(&self.wake, &1_u64.to_ne_bytes());
    }

    /// Notes bytes of the program that have been sent to the server: there is room for others.
    pub(crate) fn sent(&self, bytes: usize) {
        self.held.fetch_sub(bytes, Ordering::Relaxed);
        let _ = rustix::io::write(&self.wake, &1_u64.to_ne_bytes());
    }

    /// Closes the port. Gives what it has done.
    pub(crate) fn close(mut self) -> Report {
        self.stop()
    }

    fn stop(&mut self) -> Report {
        self.order(Order::Close);
        self.thread.take().and_then(|thread| thread.join().ok()).unwrap_or_default()
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        if self.thread.is_some() {
            self.stop();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::net::TcpStream;
    use std::time::{Duration, Instant};

    use tokio::sync::mpsc::unbounded_channel;

    use super::*;
    use crate::clock::{Clock, now_unix_ns};

    /// A port for a robot at 300 baud, in a world whose ticks are so long that it never stands still here.
    fn slow(hold: Hold, number: usize, tell: UnboundedSender<(usize, Told)>) -> (Line, TcpStream) {
        let place = Endpoint::Rfc2217(([127, 0, 0, 1], 0).into());
        let settings = Some(Settings::new_8n1(300));
        let line =
            Line::open((None, &place, Reach::OwnUser), hold, settings, 100_000_000_000, (number, tell))
                .unwrap();
        let clock = Clock { sim_ns: 0, unix_ns: now_unix_ns(), factor: 1.0 };
        line.order(Order::Bytes { clock, baud: None, bytes: Vec::new() });
        let program = TcpStream::connect(line.place.strip_prefix("rfc2217:").unwrap()).unwrap();
        (line, program)
    }

    #[test]
    fn the_robot_gets_what_a_slower_program_writes_no_earlier_than_that_sends_it() {
        let (tell, mut told) = unbounded_channel();
        let (line, mut program) = slow(Hold::new(0), 0, tell);
        let begin = Instant::now();
        // Two stop bits, and then three characters of 36.7 ms each.
        program.write_all(&[255, 250, 44, 4, 2, 255, 240, b'a', b'b', b'c']).unwrap();
        let (mut heard, character) = (Vec::new(), Duration::from_micros(36_600));
        while heard.len() < 3 {
            let Some((0, what)) = told.blocking_recv() else { panic!("the port is closed") };
            let Told::Bytes(bytes) = what else { continue };
            heard.extend(bytes);
            let sent = character * (heard.len() as u32 - 1);
            assert!(begin.elapsed() >= sent, "{heard:?} after {:?}", begin.elapsed());
        }
        assert_eq!(heard, b"abc");
        assert_eq!(line.close().taken, 3);
    }

    #[test]
    fn a_program_at_another_port_of_a_cable_that_is_taken_is_sent_away() {
        let (tell, mut told) = unbounded_channel();
        let hold = Hold::new(0);
        let (first, _program) = slow(hold.clone(), 0, tell.clone());
        assert_eq!(told.blocking_recv(), Some((0, Told::Opened)));
        let (second, _other) = slow(hold.beside(1), 1, tell);
        assert_eq!(told.blocking_recv(), Some((1, Told::Refused)));
        assert_eq!((first.close().opened, second.close().opened), (1, 0));
    }
}

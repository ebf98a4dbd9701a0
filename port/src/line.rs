//! A port's thread, as the rest of the program has it.

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
use crate::uart::Settings;

/// A port that is open for programs.
#[derive(Debug)]
pub(crate) struct Line {
    /// The sensor's place in the robot's description whose own cable it is; none for the microcontroller's.
    pub(crate) sensor: Option<u32>,
    /// Where programs find it.
    pub(crate) place: String,
    orders: Sender<Order>,
    wake: OwnedFd,
    held: Arc<AtomicUsize>,
    thread: Option<JoinHandle<Report>>,
}

impl Line {
    /// Opens a port at a place, at a cable whose UART at the robot's end is set so, if it has one. `number` is told with all that
    /// happens.
    pub(crate) fn open(
        (sensor, place): (Option<u32>, &Endpoint),
        hold: Hold,
        settings: Option<Settings>,
        step_ns: u64,
        (number, told): (usize, UnboundedSender<(usize, Told)>),
    ) -> Result<Self, PortError> {
        let medium = Medium::open(place, settings.as_ref())?;
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

    /// Tells the thread something.
    pub(crate) fn order(&self, order: Order) {
        // Both fail only when the thread is gone.
        drop(self.orders.send(order));
        let _ = rustix::io::write(&self.wake, &1_u64.to_ne_bytes());
    }

    /// So many bytes of the program have been sent to the server: there is room for others.
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

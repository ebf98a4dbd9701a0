//! The server with its clients, in turns.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use baudbot_server::{Embedded, Limit, Limits};
use bytes::Bytes;
use serde_json::Value;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::mpsc;

use crate::idle::Parked;
use crate::orders;

/// The port of [orders]; all others are of pages and brains.
pub const ORDERS: u32 = 0;

/// A server and what it has to say.
pub struct Page {
    runtime: Runtime,
    parked: Parked,
    server: Embedded,
    /// Where the messages of each port go.
    ports: BTreeMap<u32, mpsc::UnboundedSender<Bytes>>,
    outbox: Outbox,
}

/// Messages, each with its port.
#[derive(Clone, Default)]
struct Outbox(Arc<Mutex<VecDeque<(u32, Bytes)>>>);

impl Page {
    /// A server without worlds, whose recordings are in this folder, which must be there.
    ///
    /// # Errors
    /// If there is no clock.
    pub fn new(recordings: PathBuf) -> io::Result<Self> {
        let parked = Parked::default();
        let noted = parked.clone();
        let runtime =
            Builder::new_current_thread().enable_time().on_thread_park(move || noted.note()).build()?;
        // Nobody else is there to take more than their share, or to be harmed by a world that lags.
        let limits = Limits::default().with(Limit::Memory, MEMORY_BYTES).with(Limit::OverloadAfter, 0);
        let server = Embedded::new(limits, recordings);
        Ok(Self { runtime, parked, server, ports: BTreeMap::new(), outbox: Outbox::default() })
    }

    /// Takes a message that has come through a port: an order, or one of `page.proto`. The first one opens the port.
    pub fn take(&mut self, port: u32, message: Bytes) {
        if port == ORDERS {
            let (services, outbox) = (self.server.services(), self.outbox.clone());
            let tell = move |value: Value| outbox.put(ORDERS, value.to_string().into());
            self.runtime.spawn(async move { orders::carry_out(&message, services, tell).await });
            return;
        }
        let _inside = self.runtime.enter();
        let (server, outbox) = (&self.server, &self.outbox);
        let requests = self.ports.entry(port).or_insert_with(|| {
            let (requests, mut responses) = server.page();
            let outbox = outbox.clone();
            tokio::spawn(async move {
                while let Some(response) = responses.recv().await {
                    outbox.put(port, response);
                }
            });
            requests
        });
        // A client that says what no client says is served no more.
        let _ = requests.send(message);
    }

    /// A client is gone.
    pub fn close(&mut self, port: u32) {
        self.ports.remove(&port);
    }

    /// Works until there is nothing to do, or for so long. Gives whether there is more to do at once; if not, there may be in some
    /// milliseconds.
    pub fn turn(&mut self, at_most: Duration) -> bool {
        !self.runtime.block_on(self.parked.work(at_most))
    }

    /// The next message for a client, with its port.
    pub fn next_message(&mut self) -> Option<(u32, Bytes)> {
        self.outbox.lock().pop_front()
    }
}

impl Outbox {
    fn put(&self, port: u32, message: Bytes) {
        self.lock().push_back((port, message));
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<(u32, Bytes)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What worlds, states and snapshots may have: a browser gives a page no more than 4 GiB.
const MEMORY_BYTES: u64 = 1 << 30;

//! A network that is simulated: bytes take time, arrive in parts, and connections break in all ways that TCP knows.
//!
//! The faults that TCP hides are hidden here, too: no byte is lost, doubled or overtaken on a connection that lives.
//! While a host is cut off its bytes wait, as they would be sent again and again. A connection may end in good order,
//! or be reset at both ends; it may also be *lost*: then one end, or neither, gets the end, and what is written is
//! lost.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::time::{Instant, Sleep, sleep_until};

use super::chance::Chance;

/// The network between a server and its clients. Clones are the same.
#[derive(Clone)]
pub(crate) struct Network(Arc<Shared>);

struct Shared {
    seed: u64,
    began: Instant,
    hosts: Mutex<BTreeMap<String, Host>>,
    incoming: UnboundedSender<End>,
    /// A fingerprint of what was read, where and when. The order of what happens at one instant makes no difference.
    trace: Mutex<u64>,
}

/// A host of clients.
#[derive(Default)]
struct Host {
    /// The instant until which it is cut off.
    cut_until: Option<Instant>,
    /// Connections that it has made.
    made: u64,
    connections: Vec<Weak<Mutex<Connection>>>,
}

/// The kind of a connection's loss.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Loss {
    /// Both ends get the reset at once.
    Reset,
    /// The client's end is gone, and the server does not notice.
    ClientGone,
    /// The server's end is gone, and the client does not notice.
    ServerGone,
    /// Neither end notices.
    Silent,
}

const CLIENT: usize = 0;
const SERVER: usize = 1;

struct Connection {
    name: String,
    host: String,
    /// The bytes of each end.
    pipes: [Pipe; 2],
    /// Whether an end has got the reset of the connection.
    is_reset: [bool; 2],
    /// The instant from which on an end knows that the other one is gone, and takes nothing.
    is_refused: [Option<Instant>; 2],
    /// Bytes that are written from now on are lost.
    is_lost: bool,
}

struct Pipe {
    chance: Chance,
    /// Pieces, each with when it arrives.
    pieces: VecDeque<(Instant, Vec<u8>)>,
    bytes: usize,
    last: Instant,
    /// The instant at which the end of what is written arrives.
    end: Option<Instant>,
    reader: Option<Waker>,
    writer: Option<Waker>,
}

/// Bytes on their way, at most: further ones are not taken.
const WINDOW: usize = 64 << 10;

/// One end of a connection.
pub(crate) struct End {
    network: Network,
    connection: Arc<Mutex<Connection>>,
    side: usize,
    sleep: Pin<Box<Sleep>>,
}

impl Network {
    /// A network, and the connections that arrive at its server.
    pub(crate) fn new(seed: u64) -> (Self, UnboundedReceiver<End>) {
        let (incoming, arrived) = unbounded_channel();
        let (hosts, trace) = (Mutex::default(), Mutex::default());
        (Self(Arc::new(Shared { seed, began: Instant::now(), hosts, incoming, trace })), arrived)
    }

    /// A connection of this host to the server.
    pub(crate) async fn connect(&self, host: &str) -> io::Result<End> {
        let (name, mut chance) = {
            let mut hosts = self.hosts();
            let host_state = hosts.entry(host.to_owned()).or_default();
            host_state.made += 1;
            let name = format!("{host}/{}", host_state.made);
            let chance = Chance::of(self.0.seed, &name);
            (name, chance)
        };
        if chance.one_in(40) {
            return Err(io::ErrorKind::ConnectionRefused.into());
        }
        for _ in 0..2 {
            sleep_until(self.arrival(host, &mut chance)).await;
        }
        let now = Instant::now();
        let pipe = |side| Pipe {
            chance: Chance::of(self.0.seed, &format!("{name}>{side}")),
            pieces: VecDeque::new(),
            bytes: 0,
            last: now,
            end: None,
            reader: None,
            writer: None,
        };
        let pipes = [pipe(CLIENT), pipe(SERVER)];
        let host = host.to_owned();
        let connection = Connection {
            name,
            host: host.clone(),
            pipes,
            is_reset: [false; 2],
            is_refused: [None; 2],
            is_lost: false,
        };
        let connection = Arc::new(Mutex::new(connection));
        self.hosts().entry(host).or_default().connections.push(Arc::downgrade(&connection));
        let [near, far] = [CLIENT, SERVER].map(|side| End {
            network: self.clone(),
            connection: Arc::clone(&connection),
            side,
            sleep: Box::pin(sleep_until(now)),
        });
        self.0.incoming.send(far).map_err(|_| io::Error::from(io::ErrorKind::ConnectionRefused))?;
        Ok(near)
    }

    /// Cuts a host off for so long.
    pub(crate) fn cut(&self, host: &str, time: Duration) {
        let until = Instant::now() + time;
        let mut hosts = self.hosts();
        let host = hosts.entry(host.to_owned()).or_default();
        host.cut_until = Some(host.cut_until.map_or(until, |other| other.max(until)));
        for connection in host.connections.iter().filter_map(Weak::upgrade) {
            lock(&connection).delay(until);
        }
    }

    /// Loses the newest connection of a host.
    pub(crate) fn lose(&self, host: &str, how: Loss) {
        let hosts = self.hosts();
        let newest = hosts.get(host).and_then(|host| host.connections.iter().rev().find_map(Weak::upgrade));
        drop(hosts);
        if let Some(connection) = newest {
            lock(&connection).lose(how);
        }
    }

    /// Ends at the server that are not closed.
    pub(crate) fn open(&self) -> usize {
        let hosts = self.hosts();
        hosts
            .values()
            .flat_map(|host| &host.connections)
            .filter(|connection| connection.strong_count() > 0)
            .count()
    }

    /// A fingerprint of what was read, where and when.
    pub(crate) fn trace(&self) -> u64 {
        *lock(&self.0.trace)
    }

    fn note(&self, name: &str, side: usize, what: u8) {
        let at = self.0.began.elapsed().as_nanos() as u64;
        let mut event = Chance::of(at ^ (u64::from(what) << 56) ^ ((side as u64) << 55), name);
        let mut trace = lock(&self.0.trace);
        *trace = trace.wrapping_add(event.next());
    }

    /// The instant at which what a host sends or is sent now arrives.
    fn arrival(&self, host: &str, chance: &mut Chance) -> Instant {
        let now = Instant::now();
        let cut = self.hosts().get(host).and_then(|host| host.cut_until);
        let base = cut.map_or(now, |until| until.max(now));
        // Now and then a segment is lost, and sent again later.
        let again = if chance.one_in(200) { chance.ms(200, 3000) } else { Duration::ZERO };
        base + Duration::from_micros(chance.below(20_000)) + again
    }

    fn hosts(&self) -> MutexGuard<'_, BTreeMap<String, Host>> {
        lock(&self.0.hosts)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Connection {
    fn wake(&mut self) {
        for pipe in &mut self.pipes {
            pipe.reader.take().into_iter().chain(pipe.writer.take()).for_each(Waker::wake);
        }
    }

    /// Bytes on their way arrive after this.
    fn delay(&mut self, until: Instant) {
        for pipe in &mut self.pipes {
            for at in pipe.pieces.iter_mut().map(|(at, _)| at).chain(&mut pipe.end) {
                *at = (*at).max(until);
            }
            pipe.last = pipe.last.max(until);
        }
        self.wake();
    }

    fn lose(&mut self, how: Loss) {
        match how {
            Loss::Reset => self.is_reset = [true; 2],
            Loss::ClientGone => self.is_reset[CLIENT] = true,
            Loss::ServerGone => self.is_reset[SERVER] = true,
            Loss::Silent => {}
        }
        self.is_lost = true;
        for pipe in &mut self.pipes {
            pipe.pieces.clear();
            pipe.end = None;
        }
        self.is_refused = [None; 2];
        self.wake();
    }
}

impl End {
    fn reset() -> io::Error {
        io::ErrorKind::ConnectionReset.into()
    }
}

impl AsyncRead for End {
    fn poll_read(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let Self { network, connection, side, sleep } = self.get_mut();
        loop {
            let mut connection = lock(connection);
            if connection.is_reset[*side] {
                return Poll::Ready(Err(Self::reset()));
            }
            let Connection { name, pipes, .. } = &mut *connection;
            let pipe = &mut pipes[1 - *side];
            let next = pipe.pieces.front().map(|(at, _)| *at).or(pipe.end);
            let Some(at) = next else {
                pipe.reader = Some(context.waker().clone());
                return Poll::Pending;
            };
            if at > Instant::now() {
                pipe.reader = Some(context.waker().clone());
                drop(connection);
                sleep.as_mut().reset(at);
                if sleep.as_mut().poll(context).is_pending() {
                    return Poll::Pending;
                }
                continue;
            }
            network.note(name, *side, 0);
            if let Some((_, piece)) = pipe.pieces.front_mut() {
                // A part of it, of up to eight.
                let most = (piece.len() * (1 + pipe.chance.below(16).min(7) as usize)).div_ceil(8);
                let n = most.min(buffer.remaining());
                buffer.put_slice(&piece[..n]);
                piece.drain(..n);
                if piece.is_empty() {
                    pipe.pieces.pop_front();
                }
                pipe.bytes -= n;
                pipe.writer.take().into_iter().for_each(Waker::wake);
            }
            return Poll::Ready(Ok(()));
        }
    }
}

impl AsyncWrite for End {
    fn poll_write(self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let Self { network, connection, side, .. } = self.get_mut();
        let mut connection = lock(connection);
        let Connection { host, pipes, is_reset, is_refused, is_lost, .. } = &mut *connection;
        if is_reset[*side] || is_refused[*side].is_some_and(|from| from <= Instant::now()) {
            return Poll::Ready(Err(Self::reset()));
        }
        let pipe = &mut pipes[*side];
        let n = bytes.len().min(WINDOW - pipe.bytes);
        if n == 0 && !bytes.is_empty() {
            pipe.writer = Some(context.waker().clone());
            return Poll::Pending;
        }
        pipe.bytes += n;
        if !*is_lost {
            pipe.last = pipe.last.max(network.arrival(host, &mut pipe.chance));
            pipe.pieces.push_back((pipe.last, bytes[..n].to_vec()));
            pipe.reader.take().into_iter().for_each(Waker::wake);
        }
        Poll::Ready(Ok(n))
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.get_mut().close();
        Poll::Ready(Ok(()))
    }
}

impl End {
    /// Ends the stream to the other end.
    fn close(&self) {
        let mut connection = lock(&self.connection);
        let Connection { host, pipes, is_lost, .. } = &mut *connection;
        let pipe = &mut pipes[self.side];
        if !*is_lost && pipe.end.is_none() {
            pipe.last = pipe.last.max(self.network.arrival(host, &mut pipe.chance));
            pipe.end = Some(pipe.last);
            connection.wake();
        }
    }
}

impl Drop for End {
    fn drop(&mut self) {
        self.close();
        let mut connection = lock(&self.connection);
        connection.is_refused[1 - self.side] = connection.pipes[self.side].end;
    }
}

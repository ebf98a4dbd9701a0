//! Bytes that wait for clients that do not read them.
//!
//! # Need
//!
//! A call costs its client some bytes, and the server what the answer to it has. A client that asks and does not read leaves that with the
//! server, as often as it asks.
//!
//! # Assumptions
//!
//! A client that reads takes what is there within milliseconds. One that is slower than all others has the oldest bytes waiting.
//!
//! # Mechanism
//!
//! - Bytes that wait for a client are in an [`outbox`](InForce::outbox), which counts them for its stream, its caller
//!   and the server.
//! - An outbox with more than a stream may have takes no more: its writer leaves something out, or waits.
//! - When a caller, or the server, has more than it may, the slowest of the streams ends: what waits for it is dropped at once, and its client
//!   is told why, once it reads. A stream that is alone is never ended: what waits for it is a single long answer.

use std::collections::{BTreeMap, VecDeque};
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::task::{Context, Poll};

use bytes::Bytes;
use futures_util::task::AtomicWaker;
use prost::{DecodeError, Message};
use tokio_stream::Stream;
use tonic::Status;

use super::InForce;
use super::accounts::{Account, Tally};
use super::limit::Limit;
use crate::clock;

/// All that waits in a server.
#[derive(Default)]
pub(super) struct Unread {
    held: AtomicU64,
    /// The counter of what clients have taken.
    takes: AtomicU64,
    last_number: AtomicU64,
    streams: Mutex<BTreeMap<u64, Weak<Shared>>>,
}

impl Unread {
    /// Bytes that wait.
    pub(super) fn held(&self) -> u64 {
        self.held.load(Ordering::Relaxed)
    }

    fn streams(&self) -> MutexGuard<'_, BTreeMap<u64, Weak<Shared>>> {
        // The map is consistent between any two of its changes, so a panic elsewhere does not spoil it.
        self.streams.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A message in pieces, one behind the other. Pieces may be parts of other messages, too.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parts(pub(crate) Vec<Bytes>);

impl Parts {
    pub(crate) fn len(&self) -> usize {
        self.0.iter().map(Bytes::len).sum()
    }

    /// The message.
    ///
    /// # Errors
    /// If it is another one.
    pub(crate) fn decode<M: Message + Default>(self) -> Result<M, DecodeError> {
        M::decode(self.0.concat().as_slice())
    }
}

/// The end of an outbox that fills it.
pub(crate) struct Outbox(Arc<Shared>);

/// The end of an outbox that empties it.
pub(crate) struct Inbox(Arc<Shared>);

/// The bytes that wait for one stream.
struct Shared {
    limits: InForce,
    payer: Arc<Tally>,
    /// The stream's name, for the log and for its client.
    what: String,
    /// Most messages.
    places: usize,
    number: u64,
    /// Bytes of messages that wait.
    queued: AtomicU64,
    /// The count of all streams' taken bytes when some of this one's were taken, or when it began to wait.
    took: AtomicU64,
    queue: Mutex<Queue>,
    reader: AtomicWaker,
}

#[derive(Default)]
struct Queue {
    messages: VecDeque<Parts>,
    end: Option<End>,
}

/// The reason why nothing more comes.
enum End {
    /// The writer is done.
    Done,
    /// The reader has gone.
    Deserted,
    /// The stream was the slowest.
    Cut(Status),
}

impl InForce {
    /// An outbox of this caller with so many places for messages.
    pub(crate) fn outbox(&self, payer: &Arc<Tally>, what: &str, places: usize) -> (Outbox, Inbox) {
        let unread = self.unread();
        let number = unread.last_number.fetch_add(1, Ordering::Relaxed);
        let shared = Arc::new(Shared {
            limits: self.clone(),
            payer: Arc::clone(payer),
            what: what.to_owned(),
            places,
            number,
            queued: AtomicU64::new(0),
            took: AtomicU64::new(0),
            queue: Mutex::default(),
            reader: AtomicWaker::new(),
        });
        unread.streams().insert(number, Arc::downgrade(&shared));
        (Outbox(Arc::clone(&shared)), Inbox(shared))
    }

    /// Counts bytes to this caller as requests that would take as long.
    pub(crate) fn charge(&self, tally: &Tally, bytes: usize) {
        if let Some(per_s) = self.requests_per_s(tally) {
            let requests = u32::try_from(bytes / BYTES_A_REQUEST).unwrap_or(u32::MAX);
            tally.charge(clock::now(), per_s, requests);
        }
    }

    /// Ends the slowest streams of a payer that leaves too much unread.
    fn enforce(&self, payer: &Arc<Tally>) {
        if let Some(most) = self.value_for(Limit::UnreadPerCaller, payer) {
            while payer.unread() > most && self.cut_slowest(Some(payer), Limit::UnreadPerCaller, most) {}
        }
        let most = self.value(Limit::Unread);
        while self.unread().held() > most && self.cut_slowest(None, Limit::Unread, most) {}
    }

    /// Ends the slowest stream of this caller, or of the one that leaves most unread; `false` if there are not two of which one can be ended.
    fn cut_slowest(&self, payer: Option<&Arc<Tally>>, limit: Limit, most: u64) -> bool {
        let waiting = |stream: &Arc<Shared>| {
            stream.queued.load(Ordering::Relaxed) > 0 && *stream.payer.account() != Account::Process
        };
        let streams: Vec<_> = self.unread().streams().values().filter_map(Weak::upgrade).collect();
        let mut waiting: Vec<_> = streams.into_iter().filter(waiting).collect();
        let heaviest = waiting.iter().max_by_key(|stream| stream.payer.unread());
        let heaviest = heaviest.map(|stream| Arc::clone(&stream.payer));
        let alone = waiting.len() < 2;
        let payer = payer.cloned().or(heaviest);
        waiting.retain(|stream| payer.as_ref().is_some_and(|payer| Arc::ptr_eq(payer, &stream.payer)));
        if alone || (limit == Limit::UnreadPerCaller && waiting.len() < 2) {
            return false;
        }
        let slowest =
            waiting.iter().min_by_key(|stream| (stream.took.load(Ordering::Relaxed), stream.number));
        slowest.is_some_and(|slowest| slowest.cut(limit, most))
    }
}

impl Shared {
    fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn charge(&self, bytes: u64) {
        let unread = self.limits.unread();
        if self.queued.fetch_add(bytes, Ordering::Relaxed) == 0 {
            self.took.store(unread.takes.load(Ordering::Relaxed), Ordering::Relaxed);
        }
        self.payer.add_unread(bytes);
        unread.held.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Notes bytes that wait here no more, but may still be counted.
    fn unqueue(&self, bytes: u64) {
        self.queued.fetch_sub(bytes, Ordering::Relaxed);
    }

    /// Notes bytes that are not there any more.
    fn uncount(&self, bytes: u64) {
        self.payer.sub_unread(bytes);
        self.limits.unread().held.fetch_sub(bytes, Ordering::Relaxed);
    }

    /// Something was taken by the client.
    fn note_taken(&self) {
        let takes = self.limits.unread().takes.fetch_add(1, Ordering::Relaxed) + 1;
        self.took.store(takes, Ordering::Relaxed);
    }

    /// Drops what waits, and ends it so; `false` if it has ended otherwise.
    fn end(&self, end: End) -> bool {
        let dropped = {
            let mut queue = self.queue();
            if matches!(queue.end, Some(End::Deserted | End::Cut(_))) {
                return false;
            }
            queue.end = Some(end);
            std::mem::take(&mut queue.messages)
        };
        let bytes: usize = dropped.iter().map(Parts::len).sum();
        self.unqueue(bytes as u64);
        self.uncount(bytes as u64);
        true
    }

    /// Ends the stream, as it is the slowest.
    fn cut(&self, limit: Limit, most: u64) -> bool {
        let whose = if limit == Limit::Unread { "all callers leave" } else { "it leaves" };
        let what = format!(
            "the stream {} ends, as it is the slowest of {} and {whose} {:.0} MB unread",
            self.what,
            self.payer.account(),
            most as f64 / 1e6
        );
        let status = self.limits.refuse(limit, what, None).into();
        let is_cut = self.end(End::Cut(status));
        self.reader.wake();
        is_cut
    }
}

impl Outbox {
    /// Places that are free.
    pub(crate) fn places(&self) -> usize {
        self.0.places.saturating_sub(self.0.queue().messages.len())
    }

    /// Whether its stream has less waiting than it may, and its caller has not had more than its part of the server's
    /// output.
    pub(crate) fn has_budget(&self) -> bool {
        let most = self.0.limits.value(Limit::UnreadPerStream);
        self.0.queued.load(Ordering::Relaxed) < most && self.0.limits.has_budget(&self.0.payer)
    }

    /// Adds a message; `false` if it has ended. A payer with too much waiting then loses its slowest stream.
    pub(crate) fn push(&self, message: Parts) -> bool {
        let bytes = message.len() as u64;
        {
            let mut queue = self.0.queue();
            if queue.end.is_some() {
                return false;
            }
            queue.messages.push_back(message);
            // Under the lock, as it may be dropped right after it.
            self.0.charge(bytes);
        }
        self.0.reader.wake();
        self.0.limits.enforce(&self.0.payer);
        true
    }

    /// Whether the reader has gone.
    pub(crate) fn is_closed(&self) -> bool {
        self.0.queue().end.is_some()
    }
}

impl Drop for Outbox {
    fn drop(&mut self) {
        self.0.queue().end.get_or_insert(End::Done);
        self.0.reader.wake();
    }
}

impl Inbox {
    /// The reason for its end, if it was the slowest: the first time.
    pub(crate) fn take_why_cut(&self) -> Option<Status> {
        let mut queue = self.0.queue();
        match queue.end.take() {
            Some(End::Cut(status)) => {
                queue.end = Some(End::Deserted);
                Some(status)
            }
            other => {
                queue.end = other;
                None
            }
        }
    }

    /// Whether nothing waits, and no end has to be sent.
    pub(crate) fn is_empty(&self) -> bool {
        let queue = self.0.queue();
        queue.messages.is_empty() && !matches!(queue.end, Some(End::Cut(_)))
    }

    /// Wakes this task when something comes, or when it ends.
    pub(crate) fn register(&self, context: &Context<'_>) {
        self.0.reader.register(context.waker());
    }

    /// A piece of what waits. It is counted until it is dropped, and has no other bytes in memory with it.
    pub(crate) fn take_piece(&self) -> Option<Bytes> {
        let mut queue = self.0.queue();
        let message = queue.messages.front_mut()?;
        let part = message.0.first_mut()?;
        let piece = if part.len() <= PIECE {
            let piece = message.0.remove(0);
            if message.0.is_empty() {
                queue.messages.pop_front();
            }
            piece
        } else {
            Bytes::copy_from_slice(&part.split_to(PIECE))
        };
        self.0.unqueue(piece.len() as u64);
        Some(Bytes::from_owner(Piece { bytes: piece, shared: Arc::clone(&self.0) }))
    }
}

impl Stream for Inbox {
    type Item = Result<Parts, Status>;

    fn poll_next(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.register(context);
        if let Some(status) = self.take_why_cut() {
            return Poll::Ready(Some(Err(status)));
        }
        let mut queue = self.0.queue();
        if let Some(message) = queue.messages.pop_front() {
            let bytes = message.len() as u64;
            self.0.unqueue(bytes);
            self.0.uncount(bytes);
            self.0.note_taken();
            return Poll::Ready(Some(Ok(message)));
        }
        if queue.end.is_some() { Poll::Ready(None) } else { Poll::Pending }
    }
}

impl Drop for Inbox {
    fn drop(&mut self) {
        self.0.end(End::Deserted);
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        self.limits.unread().streams().remove(&self.number);
    }
}

/// The number of bytes to a caller for which it could have made another request.
const BYTES_A_REQUEST: usize = 16 << 10;

/// Bytes that are handed on at a time: what a stream that has ended still has with the network.
const PIECE: usize = 16 << 10;

/// A piece that is on its way.
struct Piece {
    bytes: Bytes,
    shared: Arc<Shared>,
}

impl AsRef<[u8]> for Piece {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

impl Drop for Piece {
    fn drop(&mut self) {
        self.shared.uncount(self.bytes.len() as u64);
        self.shared.note_taken();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;

    fn limits(unread: u64, per_caller: u64) -> InForce {
        InForce::new(Limits::none().with(Limit::Unread, unread).with(Limit::UnreadPerCaller, per_caller))
    }

    fn tally(limits: &InForce, last: u8) -> Arc<Tally> {
        limits.tally(&Account::of_address([10, 0, 0, last].into()))
    }

    fn bytes(count: usize) -> Parts {
        Parts(vec![Bytes::from(vec![0; count])])
    }

    #[test]
    fn the_slowest_stream_of_a_caller_with_too_much_ends_by_name_and_no_more_waits_than_the_limit() {
        let limits = limits(u64::MAX, 100_000);
        let (greedy, other) = (tally(&limits, 7), tally(&limits, 8));
        let streams: Vec<_> = (0..20).map(|n| limits.outbox(&greedy, &format!("Watch {n}"), 8)).collect();
        let quiet = limits.outbox(&other, "Watch", 8);
        assert!(quiet.0.push(bytes(50_000)));
        for (n, (outbox, _)) in streams.iter().enumerate() {
            assert!(outbox.push(bytes(10_000)));
            assert!(greedy.unread() <= 100_000, "{n}: {}", greedy.unread());
            // The first is read each time, and so is not the slowest.
            if let Some(piece) = streams[0].1.take_piece() {
                drop(piece);
                streams[0].0.push(bytes(10_000));
            }
        }
        let whys: Vec<_> = streams.iter().map(|(_, inbox)| inbox.take_why_cut()).collect();
        let ended: Vec<_> = (0..20).filter(|n| whys[*n].is_some()).collect();
        assert_eq!(ended, (1..=10).collect::<Vec<_>>(), "those that have waited longest");
        let text = whys[1].as_ref().unwrap().message().to_owned();
        let expected =
            "the stream Watch 1 ends, as it is the slowest of the address 10.0.0.7 and it leaves 0 MB unread";
        assert!(text.starts_with(expected), "{text}");
        assert!(!streams[1].0.push(bytes(1)) && streams[1].0.is_closed());
        assert!(quiet.1.take_why_cut().is_none(), "another caller");
        drop(streams);
        assert_eq!((greedy.unread(), limits.unread().held()), (0, 50_000));
    }

    #[test]
    fn when_the_server_has_too_much_it_is_the_caller_with_most_that_loses_a_stream() {
        let limits = limits(100_000, u64::MAX);
        let (much, little) = (tally(&limits, 7), tally(&limits, 8));
        let first = limits.outbox(&little, "first", 8);
        assert!(first.0.push(bytes(20_000)));
        let streams: Vec<_> = (0..10).map(|n| limits.outbox(&much, &format!("{n}"), 8)).collect();
        streams.iter().for_each(|(outbox, _)| assert!(outbox.push(bytes(10_000))));
        assert_eq!(limits.unread().held(), 100_000);
        assert!(first.1.take_why_cut().is_none() && streams[0].1.take_why_cut().is_some());
        assert!(streams[2].1.take_why_cut().is_none());
    }

    #[test]
    fn a_single_long_answer_is_told_in_pieces_that_are_counted_until_they_are_gone() {
        let limits = limits(1000, 1000);
        let caller = tally(&limits, 7);
        let (outbox, inbox) = limits.outbox(&caller, "SaveWorld", 1);
        assert!(outbox.push(bytes(3 * PIECE + 1)));
        assert!(inbox.take_why_cut().is_none(), "there is no other");
        let pieces: Vec<_> = std::iter::from_fn(|| inbox.take_piece()).collect();
        assert_eq!(pieces.iter().map(Bytes::len).collect::<Vec<_>>(), [PIECE, PIECE, PIECE, 1]);
        assert_eq!(caller.unread(), 3 * PIECE as u64 + 1);
        drop(pieces);
        assert_eq!((caller.unread(), limits.unread().held()), (0, 0));
    }
}

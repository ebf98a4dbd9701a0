//! The requests of one streaming call, on their way from the page to the service: a bounded queue that keeps the newest.
//!
//! The server keeps reading the socket whatever a service does, since many calls share it. A service that does not read
//! therefore cannot slow the page down; instead the oldest requests are dropped. A page streams a brain's Steps and beliefs,
//! of which only the newest counts. The first request of a call opens it (a Hello), and is never dropped.

use std::collections::VecDeque;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use prost::bytes::Bytes;
use tokio_stream::Stream;

/// Requests that wait until the service reads them, at most.
const CAPACITY: usize = 64;

/// The page's end. The stream ends once this is dropped and all requests are read.
pub(super) struct Sender(Arc<Mutex<Queue>>);

/// The service's end.
pub(super) struct Requests(Arc<Mutex<Queue>>);

struct Queue {
    waiting: VecDeque<Bytes>,
    /// Whether the first request of the call is still the front of the queue.
    holds_first: bool,
    reader: Option<Waker>,
    is_closed: bool,
}

/// A queue that holds the first request of a call.
pub(super) fn requests(first: Bytes) -> (Sender, Requests) {
    let waiting = VecDeque::from([first]);
    let queue = Queue { waiting, holds_first: true, reader: None, is_closed: false };
    let queue = Arc::new(Mutex::new(queue));
    (Sender(Arc::clone(&queue)), Requests(queue))
}

impl Sender {
    /// Adds a request. If the queue is full, this drops the oldest one but the first of the call.
    pub(super) fn send(&self, request: Bytes) {
        let mut queue = locked(&self.0);
        if queue.waiting.len() >= CAPACITY {
            let oldest = usize::from(queue.holds_first);
            queue.waiting.remove(oldest);
        }
        queue.waiting.push_back(request);
        queue.wake();
    }
}

impl Drop for Sender {
    fn drop(&mut self) {
        let mut queue = locked(&self.0);
        queue.is_closed = true;
        queue.wake();
    }
}

impl Stream for Requests {
    type Item = Bytes;

    fn poll_next(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        let mut queue = locked(&self.0);
        match queue.waiting.pop_front() {
            Some(request) => {
                queue.holds_first = false;
                Poll::Ready(Some(request))
            }
            None if queue.is_closed => Poll::Ready(None),
            None => {
                queue.reader = Some(context.waker().clone());
                Poll::Pending
            }
        }
    }
}

impl Queue {
    fn wake(&mut self) {
        if let Some(reader) = self.reader.take() {
            reader.wake();
        }
    }
}

/// Locks the queue. Nothing panics while it is locked, and it is consistent between any two of its changes.
fn locked(queue: &Mutex<Queue>) -> MutexGuard<'_, Queue> {
    queue.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::{FutureExt, StreamExt};

    fn request(number: u64) -> Bytes {
        number.to_string().into()
    }

    fn read(requests: &mut Requests) -> Vec<u64> {
        let mut read = Vec::new();
        while let Some(Some(request)) = requests.next().now_or_never() {
            read.push(std::str::from_utf8(&request).unwrap().parse().unwrap());
        }
        read
    }

    #[test]
    fn the_first_request_and_the_newest_ones_stay() {
        let (sender, mut requests) = requests(request(0));
        (1..=1000).for_each(|number| sender.send(request(number)));
        let kept = read(&mut requests);
        assert_eq!(kept.len(), CAPACITY);
        assert_eq!((kept[0], kept[1], kept[CAPACITY - 1]), (0, 1000 - 62, 1000));
        (1..=1000).for_each(|number| sender.send(request(number)));
        assert_eq!(read(&mut requests), (937..=1000).collect::<Vec<_>>());
    }

    #[test]
    fn what_was_sent_is_read_after_the_page_is_gone_and_then_the_stream_is_over() {
        let (sender, mut requests) = requests(request(0));
        assert_eq!(read(&mut requests), [0]);
        assert!(requests.next().now_or_never().is_none(), "nothing has been sent");
        sender.send(request(1));
        drop(sender);
        assert_eq!(read(&mut requests), [1]);
        assert!(requests.next().now_or_never().unwrap().is_none());
    }
}

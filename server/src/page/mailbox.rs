//! What a page says as a brain, on its way to the brain's stream: bounded, and what is newest stays.

use std::collections::VecDeque;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use baudbot_proto::v1;
use baudbot_proto::v1::attach_request::Request;
use tokio_stream::Stream;

/// Requests that wait for the stream to read them.
const MOST: usize = 64;

/// The page's end. The stream ends once this is dropped and all is read.
pub(super) struct Sender(Arc<Mutex<Queue>>);

/// The stream's end.
pub(super) struct Mailbox(Arc<Mutex<Queue>>);

#[derive(Default)]
struct Queue {
    waiting: VecDeque<v1::AttachRequest>,
    reader: Option<Waker>,
    over: bool,
}

/// An empty one.
pub(super) fn mailbox() -> (Sender, Mailbox) {
    let queue = Arc::new(Mutex::new(Queue::default()));
    (Sender(Arc::clone(&queue)), Mailbox(queue))
}

impl Sender {
    /// Puts a request in. If there is no room, the oldest one but a Hello makes room: a Step or a belief is void once a
    /// newer one is there.
    pub(super) fn send(&self, request: v1::AttachRequest) {
        let mut queue = locked(&self.0);
        if queue.waiting.len() >= MOST {
            let opens =
                queue.waiting.front().is_some_and(|first| matches!(first.request, Some(Request::Hello(_))));
            queue.waiting.remove(usize::from(opens));
        }
        queue.waiting.push_back(request);
        queue.wake();
    }
}

impl Drop for Sender {
    fn drop(&mut self) {
        let mut queue = locked(&self.0);
        queue.over = true;
        queue.wake();
    }
}

impl Stream for Mailbox {
    type Item = v1::AttachRequest;

    fn poll_next(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        let mut queue = locked(&self.0);
        match queue.waiting.pop_front() {
            Some(request) => Poll::Ready(Some(request)),
            None if queue.over => Poll::Ready(None),
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

/// Nobody panics while holding it, and a queue is whole between any two of its changes.
fn locked(queue: &Mutex<Queue>) -> MutexGuard<'_, Queue> {
    queue.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::{FutureExt, StreamExt};

    fn step(turn: u64) -> v1::AttachRequest {
        v1::AttachRequest { request: Some(Request::Step(v1::Step { turn, robots: Vec::new() })) }
    }

    fn turns(mailbox: &mut Mailbox) -> Vec<Option<u64>> {
        let mut turns = Vec::new();
        while let Some(Some(v1::AttachRequest { request })) = mailbox.next().now_or_never() {
            turns.push(match request {
                Some(Request::Step(step)) => Some(step.turn),
                Some(Request::Hello(_) | Request::Annotate(_)) | None => None,
            });
        }
        turns
    }

    #[test]
    fn the_hello_and_the_newest_steps_stay() {
        let (sender, mut mailbox) = mailbox();
        sender.send(v1::AttachRequest { request: Some(Request::Hello(v1::Hello::default())) });
        (1..=1000).for_each(|turn| sender.send(step(turn)));
        let kept = turns(&mut mailbox);
        assert_eq!(kept.len(), MOST);
        assert_eq!((kept[0], kept[1], kept[MOST - 1]), (None, Some(1000 - 62), Some(1000)));
        (1..=1000).for_each(|turn| sender.send(step(turn)));
        assert_eq!(turns(&mut mailbox), (937..=1000).map(Some).collect::<Vec<_>>());
    }

    #[test]
    fn what_was_said_is_read_after_the_page_is_gone_and_then_it_is_over() {
        let (sender, mut mailbox) = mailbox();
        assert!(mailbox.next().now_or_never().is_none(), "nothing has been said");
        sender.send(step(1));
        drop(sender);
        assert_eq!(turns(&mut mailbox), [Some(1)]);
        assert!(mailbox.next().now_or_never().unwrap().is_none());
    }
}

//! Answers that are made once for all who ask meanwhile.
//!
//! # Need
//!
//! A question has a few bytes, and the answer to it may have a million, for which a world is copied and converted. A
//! client that asks a thousand times must not have it made a thousand times.
//!
//! # Mechanism
//!
//! One answer of a kind and a world is made at a time. A caller that asks meanwhile waits for the next one, which is
//! made for all who have asked by then: no caller gets one that is older than the question. What is made says of what
//! ([`Last::key`]); while that has not changed, it is not made again.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Weak};

use baudbot_sim::Scenario;
use bytes::Bytes;
use tokio::sync::Mutex;
use tonic::Status;

use crate::report::Version;

/// The answers about a world.
#[derive(Default)]
pub(crate) struct Answers {
    pub(crate) status: Answer<Version>,
    pub(crate) description: Answer<Weak<Scenario>>,
    /// The coverage by era and tick.
    pub(crate) coverage: Answer<(u64, u64)>,
}

/// An answer of one kind.
pub(crate) struct Answer<K> {
    asked: AtomicU64,
    made: AtomicU64,
    last: Mutex<Option<(u64, Arc<Last<K>>)>>,
}

/// The last answer.
pub(crate) struct Last<K> {
    /// The key of the answer: the state of which it was made.
    pub(crate) key: K,
    pub(crate) bytes: Bytes,
    /// The bytes behind it, of the time of the request.
    pub(crate) tail: Bytes,
}

/// The answer to a request.
pub(crate) enum Made<K> {
    /// The last answer, with another tail.
    Same {
        tail: Bytes,
    },
    New(Last<K>),
}

impl<K> Default for Answer<K> {
    fn default() -> Self {
        Self { asked: AtomicU64::new(0), made: AtomicU64::new(0), last: Mutex::default() }
    }
}

impl<K: Clone> Answer<K> {
    /// An answer that is not older than this call. `make` is given what was made last, and gives [`Made::Same`] only if there is
    /// something.
    ///
    /// # Errors
    /// If `make` fails.
    pub(crate) async fn get(
        &self,
        make: impl AsyncFnOnce(Option<&Last<K>>) -> Result<Made<K>, Status>,
    ) -> Result<Arc<Last<K>>, Status> {
        let own = self.asked.fetch_add(1, Ordering::SeqCst);
        let mut last = self.last.lock().await;
        if let Some((for_all_before, made)) = &*last
            && own < *for_all_before
        {
            return Ok(Arc::clone(made));
        }
        let for_all_before = self.asked.load(Ordering::SeqCst);
        let former = last.as_ref().map(|(_, former)| Arc::clone(former));
        let made = match (make(former.as_deref()).await?, former) {
            (Made::New(made), _) => {
                self.made.fetch_add(1, Ordering::Relaxed);
                made
            }
            (Made::Same { tail }, Some(former)) => {
                Last { key: former.key.clone(), bytes: former.bytes.clone(), tail }
            }
            (Made::Same { .. }, None) => {
                return Err(Status::internal("an answer was to be told that is not there"));
            }
        };
        let made = Arc::new(made);
        *last = Some((for_all_before, Arc::clone(&made)));
        Ok(made)
    }

    /// The number of answers that have been made.
    pub(crate) fn made(&self) -> u64 {
        self.made.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use tokio::sync::Semaphore;
    use tokio::task::yield_now;

    use super::*;

    type Numbers = Arc<Answer<u32>>;

    /// Asks for one that is made of this number once there is a permit.
    fn ask(answer: &Numbers, key: u32, permits: &Arc<Semaphore>) -> tokio::task::JoinHandle<u32> {
        let (answer, permits) = (Arc::clone(answer), Arc::clone(permits));
        tokio::spawn(async move {
            let make = async |_: Option<&Last<u32>>| {
                permits.acquire().await.unwrap().forget();
                Ok(Made::New(Last { key, bytes: Bytes::new(), tail: Bytes::new() }))
            };
            answer.get(make).await.unwrap().key
        })
    }

    async fn let_others_run() {
        for _ in 0..10 {
            yield_now().await;
        }
    }

    #[tokio::test]
    async fn whoever_asks_while_one_is_made_gets_the_next_one_which_is_made_once() {
        let (answer, permits) = (Numbers::default(), Arc::new(Semaphore::new(0)));
        let first = ask(&answer, 1, &permits);
        let_others_run().await;
        let late: Vec<_> = (0..1000).map(|_| ask(&answer, 2, &permits)).collect();
        let_others_run().await;
        permits.add_permits(1);
        assert_eq!(first.await.unwrap(), 1);
        permits.add_permits(1);
        for one in late {
            assert_eq!(one.await.unwrap(), 2, "an answer is not older than its question");
        }
        assert_eq!(answer.made(), 2);
    }

    #[tokio::test]
    async fn who_goes_leaves_the_work_to_the_next() {
        let (answer, permits) = (Numbers::default(), Arc::new(Semaphore::new(0)));
        let gone = ask(&answer, 1, &permits);
        let_others_run().await;
        gone.abort();
        assert!(gone.await.is_err());
        permits.add_permits(1);
        assert_eq!(ask(&answer, 2, &permits).await.unwrap(), 2);
        let same = answer.get(async |last| {
            assert_eq!(last.unwrap().key, 2);
            Ok(Made::Same { tail: Bytes::from_static(b"later") })
        });
        assert_eq!(same.await.unwrap().tail, "later");
        assert_eq!(answer.made(), 1, "the first was never finished");
    }
}

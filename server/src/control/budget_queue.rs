//! Budgets that are computed: few at a time, in the order of their calls, and of each caller only so many.

use std::sync::{Mutex, PoisonError};

use baudbot_access::TokenHash;
use tokio::sync::{Semaphore, SemaphorePermit};
use tonic::Status;

use crate::access::Caller;

/// Budgets that wait or are computed, by all servers of the process: each takes a core for seconds.
pub(super) struct BudgetQueue {
    places: Semaphore,
    /// The callers of the budgets in the queue; `None` for those without a token.
    callers: Mutex<Vec<Option<TokenHash>>>,
}

/// A budget's place.
pub(super) struct Place {
    _permit: SemaphorePermit<'static>,
    _share: Share,
}

/// A budget of a caller, from the call to the answer.
struct Share {
    queue: &'static BudgetQueue,
    caller: Option<TokenHash>,
}

pub(super) static BUDGETS: BudgetQueue = BudgetQueue::new();

impl BudgetQueue {
    const fn new() -> Self {
        Self { places: Semaphore::const_new(AT_A_TIME), callers: Mutex::new(Vec::new()) }
    }

    /// Waits for a place, behind those who asked before.
    ///
    /// # Errors
    /// `RESOURCE_EXHAUSTED` if the caller has its share of the queue.
    pub(super) async fn place(&'static self, caller: &Caller) -> Result<Place, Status> {
        let share = self.share(caller)?;
        let permit = self.places.acquire().await.map_err(|closed| Status::internal(closed.to_string()))?;
        Ok(Place { _permit: permit, _share: share })
    }

    fn share(&'static self, caller: &Caller) -> Result<Share, Status> {
        let (caller, most) = match caller {
            Caller::Holder(grant) => (Some(grant.hash), A_CALLER),
            Caller::Trusted | Caller::Nobody => (None, WITHOUT_TOKENS),
        };
        let mut callers = self.callers.lock().unwrap_or_else(PoisonError::into_inner);
        if callers.iter().filter(|&&other| other == caller).count() >= most {
            return Err(Status::resource_exhausted(format!(
                "{most} budgets of this caller are being computed, which is the limit; wait for their answers"
            )));
        }
        callers.push(caller);
        Ok(Share { queue: self, caller })
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        let mut callers = self.queue.callers.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(place) = callers.iter().position(|&other| other == self.caller) {
            callers.swap_remove(place);
        }
    }
}

/// Budgets that are computed at a time.
const AT_A_TIME: usize = 2;

/// Budgets of a token that wait or are computed.
const A_CALLER: usize = 4;

/// The limit for all callers without tokens together.
const WITHOUT_TOKENS: usize = 64;

#[cfg(test)]
mod tests {
    use std::pin::Pin;
    use std::sync::Arc;
    use std::task::{Context, Waker};
    use std::time::SystemTime;

    use baudbot_access::{Grant, Token};
    use tonic::Code;

    use super::*;

    #[tokio::test]
    async fn a_caller_with_its_share_is_refused_and_others_wait_for_their_turn() {
        static QUEUE: BudgetQueue = BudgetQueue::new();
        let holder = || {
            let grant = Grant::local(Token::random().unwrap().hash(), SystemTime::now());
            Caller::Holder(Arc::new(grant))
        };
        let waits = |future: Pin<&mut dyn Future<Output = Result<Place, Status>>>| {
            future.poll(&mut Context::from_waker(Waker::noop())).is_pending()
        };
        let (greedy, other) = (holder(), holder());
        let first = QUEUE.place(&greedy).await.unwrap();
        let _second = QUEUE.place(&greedy).await.unwrap();
        let (mut third, mut fourth) = (Box::pin(QUEUE.place(&greedy)), Box::pin(QUEUE.place(&greedy)));
        assert!(waits(third.as_mut()) && waits(fourth.as_mut()));
        let refused = QUEUE.place(&greedy).await.err().unwrap();
        assert_eq!(refused.code(), Code::ResourceExhausted);
        assert!(refused.message().starts_with("4 budgets of this caller"), "{refused:?}");
        let mut others = Box::pin(QUEUE.place(&other));
        assert!(waits(others.as_mut()));
        // A caller that gives up makes room, also for itself.
        drop((third, fourth, first));
        let _others = others.await.unwrap();
        assert!(waits(Box::pin(QUEUE.place(&greedy)).as_mut()));
    }
}

//! The call that a task serves.
//!
//! The gate knows the call, and the services its world. Between the two are generated code and the runtime, so the
//! call is a variable of the task, as the span of a trace is.

use std::sync::Arc;

use baudbot_proto::v1;
use tokio::task::futures::TaskLocalFuture;

use super::Record;
use crate::access::Caller;

tokio::task_local! {
    static CALL: Call;
}

/// A call that is being served.
#[derive(Clone)]
pub(crate) struct Call {
    pub(crate) caller: Caller,
    /// `None` if it is not audited.
    pub(crate) record: Option<Arc<Record>>,
}

impl Call {
    /// Serves it by this work.
    pub(crate) fn serve<F: Future>(self, work: F) -> TaskLocalFuture<Self, F> {
        CALL.scope(self, work)
    }
}

/// Notes that the present call is about a world, or about a robot in it.
pub(crate) fn note_world(name: &str) {
    let _ = CALL.try_with(|call| {
        if let Some(record) = &call.record {
            record.is_about(name);
        }
    });
}

/// Notes which robots the present call is to drive, from now on.
pub(crate) fn note_robots<'a>(hellos: impl IntoIterator<Item = &'a v1::Hello>) {
    let _ = CALL.try_with(|call| {
        if let Some(record) = &call.record {
            for v1::Hello { world, robots, .. } in hellos {
                robots.iter().for_each(|robot| record.is_about(&format!("{world}/{robot}")));
            }
            record.begin();
        }
    });
}

/// The name of the token by which the present call was made, if it was by one.
pub(crate) fn by() -> Option<String> {
    let name = |call: &Call| match &call.caller {
        Caller::Holder(grant) => Some(grant.name.to_string()),
        Caller::Trusted | Caller::Nobody => None,
    };
    CALL.try_with(name).ok().flatten()
}

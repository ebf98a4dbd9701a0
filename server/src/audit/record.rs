//! The audit log's record of a call.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use baudbot_access::Need;
use serde::Serialize;
use tonic::{Code, Status};

use super::AuditLog;
use super::file::now;

/// Worlds and robots that a call names, at most: a trainer has hundreds.
const MAX_NAMES: usize = 20;

/// Bytes of a caller's words that a line has: an error may quote them.
const MAX_TEXT: usize = 500;

/// A call, until it has ended.
pub(crate) struct Record {
    log: AuditLog,
    /// A number that distinguishes the lines of one call from those of another.
    number: u64,
    who: String,
    /// The caller's address, or its user.
    from: String,
    call: String,
    begun: Instant,
    about: Mutex<Vec<String>>,
}

/// A line.
#[derive(Serialize)]
struct Line<'a> {
    at: String,
    event: &'static str,
    number: u64,
    who: &'a str,
    from: &'a str,
    call: &'a str,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    about: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    code: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    text: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seconds: Option<f64>,
}

impl Record {
    /// The record of a call that begins. `call` is its path.
    pub(crate) fn new(log: &AuditLog, who: &str, from: String, call: &str) -> Self {
        static LAST: AtomicU64 = AtomicU64::new(0);
        let call = call.trim_start_matches('/');
        Self {
            log: log.clone(),
            number: LAST.fetch_add(1, Ordering::Relaxed) + 1,
            who: who.to_owned(),
            from,
            call: shortened(call).to_owned(),
            begun: Instant::now(),
            about: Mutex::default(),
        }
    }

    /// Whether calls that need this are audited, also if they are let in.
    pub(crate) fn is_for(need: Option<Need>) -> bool {
        match need {
            Some(Need::Operate | Need::Train | Need::Drive) => true,
            Some(Need::Nothing | Need::AnyToken | Need::Observe) | None => false,
        }
    }

    /// Adds a world or robot that the call is about.
    pub(super) fn is_about(&self, name: &str) {
        let mut about = self.about.lock().unwrap_or_else(PoisonError::into_inner);
        if about.len() < MAX_NAMES && about.iter().all(|other| other != name) {
            about.push(shortened(name).to_owned());
        }
    }

    /// Writes the record of a call that begins to drive and lasts, now that its robots are known.
    pub(crate) fn begin(&self) {
        self.write("begin", None, None);
    }

    /// Writes the record of a call that was refused before any service has seen it.
    pub(crate) fn refuse(&self, status: &Status) {
        if self.log.tells_refusal(Instant::now()) {
            self.write("refused", Some(status.code()), Some(status.message()));
        }
    }

    /// Writes the record of a call that has ended.
    pub(crate) fn end(&self, code: Code, text: &str) {
        self.write("end", Some(code), (!text.is_empty()).then_some(text));
    }

    fn write(&self, event: &'static str, code: Option<Code>, text: Option<&str>) {
        let about = self.about.lock().unwrap_or_else(PoisonError::into_inner);
        let seconds = code.is_some().then(|| (self.begun.elapsed().as_secs_f64() * 1e6).round() / 1e6);
        self.log.append(&Line {
            at: now(),
            event,
            number: self.number,
            who: &self.who,
            from: &self.from,
            call: &self.call,
            about: &about,
            code: code.map(name),
            text: text.map(shortened),
            seconds,
        });
    }
}

/// The beginning of a text that may be long.
fn shortened(text: &str) -> &str {
    &text[..text.floor_char_boundary(MAX_TEXT)]
}

/// The name of a code in the specification of gRPC.
fn name(code: Code) -> &'static str {
    match code {
        Code::Ok => "OK",
        Code::Cancelled => "CANCELLED",
        Code::Unknown => "UNKNOWN",
        Code::InvalidArgument => "INVALID_ARGUMENT",
        Code::DeadlineExceeded => "DEADLINE_EXCEEDED",
        Code::NotFound => "NOT_FOUND",
        Code::AlreadyExists => "ALREADY_EXISTS",
        Code::PermissionDenied => "PERMISSION_DENIED",
        Code::ResourceExhausted => "RESOURCE_EXHAUSTED",
        Code::FailedPrecondition => "FAILED_PRECONDITION",
        Code::Aborted => "ABORTED",
        Code::OutOfRange => "OUT_OF_RANGE",
        Code::Unimplemented => "UNIMPLEMENTED",
        Code::Internal => "INTERNAL",
        Code::Unavailable => "UNAVAILABLE",
        Code::DataLoss => "DATA_LOSS",
        Code::Unauthenticated => "UNAUTHENTICATED",
    }
}

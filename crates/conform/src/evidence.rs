//! The evidence of a run, and the verdict on it.

use std::fmt;

use crate::provocation::Provocation;
use crate::record::{Event, Record, Stream};

/// Whether a brain does what a case tests.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It does.
    Does,
    /// It does not, with what was seen.
    DoesNot(String),
    /// It has no use for it, or the thing did not come about, with the reason.
    NotUsed(String),
}

/// What is known of a run.
pub(crate) struct Evidence<'a> {
    pub(crate) record: &'a Record,
    pub(crate) plain: &'a Record,
    pub(crate) provocation: Provocation,
    /// The token that the brain was given.
    pub(crate) token: &'a str,
}

/// The verdict; an `Err` is one that needs no look at what the case is about, as there is no stream.
pub(crate) type Judgement = Result<Verdict, Verdict>;

/// A judge of a case.
pub(crate) type Judge = fn(&Evidence<'_>) -> Judgement;

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Does => "does",
            Self::DoesNot(_) => "does not",
            Self::NotUsed(_) => "not used",
        })
    }
}

pub(crate) fn does_not(why: impl Into<String>) -> Judgement {
    Ok(Verdict::DoesNot(why.into()))
}

pub(crate) fn not_used(why: impl Into<String>) -> Judgement {
    Ok(Verdict::NotUsed(why.into()))
}

/// It does, unless there is a complaint.
pub(crate) fn unless(complaint: Option<String>) -> Judgement {
    Ok(complaint.map_or(Verdict::Does, Verdict::DoesNot))
}

impl Evidence<'_> {
    pub(crate) fn stream(&self) -> Result<&Stream, Verdict> {
        self.record.first().ok_or_else(|| Verdict::DoesNot(format!("it does not attach{}", self.ended())))
    }

    /// The first stream, if the brain speaks in messages.
    pub(crate) fn messages(&self) -> Result<&Stream, Verdict> {
        let stream = self.stream()?;
        if stream.is_raw() {
            Err(Verdict::NotUsed("it reads and writes bytes".to_owned()))
        } else {
            Ok(stream)
        }
    }

    /// How the program ended, behind a sentence.
    pub(crate) fn ended(&self) -> String {
        match self.record.end.as_ref().and_then(|end| end.status) {
            Some(status) => format!("; the program ended: {status}"),
            None => String::new(),
        }
    }

    /// Whether the brain answered to the end of the run, and the complaint if it did not.
    pub(crate) fn drove_on(&self, stream: &Stream) -> Judgement {
        let answered = stream.steps().count();
        let given = stream.turns().count();
        if stream.events.iter().any(|event| matches!(event, Event::Ended)) || answered == given {
            return unless(
                (answered == 0).then(|| format!("it answers none of {given} Turns{}", self.ended())),
            );
        }
        does_not(format!("it answers {answered} of {given} Turns, and then no more{}", self.ended()))
    }
}

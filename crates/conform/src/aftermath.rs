//! The judgement of what a brain does when its world begins again or is over, or its stream is lost or refused.

use std::collections::BTreeSet;

use crate::evidence::{Evidence, Judgement, Verdict, does_not, not_used, unless};
use crate::judge::shown;
use crate::provocation::{AFTER, Provocation, REFUSED};
use crate::record::{Event, Stream};

pub(crate) fn goes_on_after_reset(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let Some(after) = stream.after(|event| matches!(event, Event::Reset)) else {
        return not_used("the run was over before");
    };
    goes_on(seen, after)
}

pub(crate) fn answers_no_old_turn(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let Some(after) = stream.after(|event| matches!(event, Event::Reset)) else {
        return not_used("the run was over before");
    };
    let first =
        after.iter().find_map(|event| if let Event::Turn(turn) = event { Some(turn.turn) } else { None });
    let Some(first) = first else { return not_used("no Turn follows") };
    let old = after
        .iter()
        .filter(|event| matches!(event, Event::Step(step) if step.turn != 0 && step.turn < first))
        .count();
    unless((old > 0).then(|| format!("{old} Steps after the reset answer Turns from before it")))
}

pub(crate) fn stays_or_leaves_well(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    if !stream.events.iter().any(|event| matches!(event, Event::Ended)) {
        return seen.drove_on(stream);
    }
    match seen.record.end.as_ref().and_then(|end| end.status) {
        Some(status) if !status.success() => {
            does_not(format!("the run is over, and the program ended: {status}"))
        }
        Some(_) | None => Ok(Verdict::Does),
    }
}

pub(crate) fn is_silent_after_the_end(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let Some(after) = stream.after(|event| matches!(event, Event::Ended)) else {
        return not_used("the run did not end");
    };
    // The second answer to a Turn may come as late, and is judged elsewhere.
    let given: BTreeSet<_> = stream.turns().map(|turn| turn.turn).collect();
    let steps = after.iter().take_while(|event| !matches!(event, Event::Turn(_) | Event::Reset));
    let steps =
        steps.filter(|event| matches!(event, Event::Step(step) if !given.contains(&step.turn))).count();
    unless((steps > 0).then(|| format!("{steps} Steps come after the run is over")))
}

pub(crate) fn goes_on_after_the_end(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    match stream.after(|event| matches!(event, Event::Reset)) {
        None => not_used("it leaves when the run is over"),
        Some(after) if after.iter().all(|event| !matches!(event, Event::Turn(_))) => {
            not_used("it leaves when the run is over")
        }
        Some(after) => goes_on(seen, after),
    }
}

/// The complaint of a brain whose world began again, if it has one.
fn goes_on(seen: &Evidence<'_>, after: &[Event]) -> Judgement {
    let steps = after.iter().filter(|event| matches!(event, Event::Step(..)));
    let outputs = steps.clone().filter(
        |event| matches!(event, Event::Step(step) if step.robots.iter().any(|part| part.output.is_some())),
    );
    unless(match (steps.count(), outputs.count()) {
        (0, _) => Some(format!("it answers no Turn afterwards{}", seen.ended())),
        (steps, 0) => Some(format!("its {steps} Steps afterwards have no output")),
        _ => None,
    })
}

/// The second stream of a brain that lost its first.
fn second<'a>(seen: &'a Evidence<'_>) -> Result<&'a Stream, Verdict> {
    let attempts = seen.record.streams.len();
    let is_there = seen.record.first().is_some_and(|stream| stream.turns().count() >= AFTER);
    match seen.record.streams.get(1) {
        Some(stream) => Ok(stream),
        None if attempts == 0 || !is_there => Err(Verdict::NotUsed("the run was over before".to_owned())),
        None => Err(Verdict::DoesNot(format!("it does not attach again{}", seen.ended()))),
    }
}

pub(crate) fn comes_back(seen: &Evidence<'_>) -> Judgement {
    goes_on(seen, &second(seen)?.events)
}

pub(crate) fn comes_back_if_it_can(seen: &Evidence<'_>) -> Judgement {
    match (comes_back(seen).unwrap_or_else(|verdict| verdict), seen.record.streams.len()) {
        (Verdict::DoesNot(why), 1) => not_used(why),
        (verdict, _) => Ok(verdict),
    }
}

pub(crate) fn greets_again(seen: &Evidence<'_>) -> Judgement {
    match (second(seen), seen.record.first()) {
        (Ok(again), Some(first)) => {
            unless((again.hello != first.hello).then(|| "the second Hello differs from the first".to_owned()))
        }
        (Err(_), _) | (_, None) => not_used("it does not attach again"),
    }
}

pub(crate) fn shows_its_token_again(seen: &Evidence<'_>) -> Judgement {
    match second(seen) {
        Ok(stream) => shown(seen, stream),
        Err(_) => not_used("it does not attach again"),
    }
}

pub(crate) fn waits_for_the_server(seen: &Evidence<'_>) -> Judgement {
    match seen.record.first() {
        None => not_used("it ends if there is no server"),
        Some(stream) => seen.drove_on(stream),
    }
}

/// A refused program ends with an error and the server's words.
pub(crate) fn gives_up(seen: &Evidence<'_>) -> Judgement {
    let words = if matches!(seen.provocation, Provocation::Refused(_)) { REFUSED } else { "deleted" };
    let Some(end) = &seen.record.end else { return not_used("the kit does not see how the program ends") };
    let Some(status) = end.status else {
        return does_not(match seen.record.streams.len() {
            0 | 1 => "it does not end".to_owned(),
            attempts => format!("it does not end, and attached {attempts} times"),
        });
    };
    if status.success() {
        return does_not("it ends as if all were well");
    }
    let is_told = end.printed.iter().any(|line| line.contains(words));
    unless((!is_told).then(|| format!("it does not print the server's words, `{words}`")))
}

//! The judgement of what a brain says while its world goes on.

use std::collections::{BTreeMap, BTreeSet};

use baudbot_proto::v1;
use baudbot_proto::v1::robot_step::Output;

use crate::evidence::{Evidence, Judgement, Verdict, does_not, not_used, unless};
use crate::record::{Event, Stream};

pub(crate) fn greets_first(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let is_early = stream.events.iter().any(|event| matches!(event, Event::BeforeHello));
    unless(match (is_early, &stream.hello) {
        (true, _) => Some("another request comes before the Hello".to_owned()),
        (false, None) => Some(format!("no Hello comes{}", seen.ended())),
        (false, Some(_)) => None,
    })
}

pub(crate) fn greets_once(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let again = stream.events.iter().filter(|event| matches!(event, Event::SecondHello)).count();
    unless((again > 0).then(|| format!("{again} more Hellos come")))
}

pub(crate) fn waits_for_welcome(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let early = stream.events.iter().any(|event| matches!(event, Event::BeforeWelcome));
    unless(early.then(|| "a Step comes before the Welcome".to_owned()))
}

pub(crate) fn names_the_world(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let world = stream.hello.as_ref().map_or("", |hello| &hello.world);
    unless((world != crate::scene::WORLD).then(|| format!("it names the world `{world}`")))
}

pub(crate) fn names_the_robots(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let named = stream.hello.as_ref().map_or(&[][..], |hello| &hello.robots);
    let (named, given) = (named.join(","), seen.record.robots.join(","));
    unless((named != given).then(|| format!("BAUDBOT_ROBOT is `{given}`, and it names `{named}`")))
}

pub(crate) fn has_a_name(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let name = stream.hello.as_ref().map_or("", |hello| &hello.brain);
    let is_bad = name.is_empty() || name.chars().count() > 64 || name.chars().any(char::is_control);
    unless(is_bad.then(|| format!("its name is {name:?}")))
}

pub(crate) fn shows_its_token(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    shown(seen, stream)
}

pub(crate) fn answers(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    seen.drove_on(stream)
}

pub(crate) fn answers_once(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let mut known = BTreeSet::new();
    let again = stream.steps().filter(|step| step.turn != 0 && !known.insert(step.turn)).count();
    unless((again > 0).then(|| format!("{again} Turns have a second answer")))
}

pub(crate) fn is_silent_unasked(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let unasked = stream.steps().filter(|step| step.turn == 0).count();
    unless((unasked > 0).then(|| format!("{unasked} Steps answer no Turn")))
}

pub(crate) fn repeats_the_number(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let given: BTreeSet<_> = stream.turns().map(|turn| turn.turn).collect();
    let wrong = stream.steps().find(|step| step.turn != 0 && !given.contains(&step.turn));
    unless(wrong.map(|step| format!("a Step answers Turn {}, which was never given", step.turn)))
}

pub(crate) fn keeps_its_promise(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    if !stream.hello.as_ref().is_some_and(|hello| hello.thinks_as_scenario) {
        return not_used("it does not promise it");
    }
    let turns: BTreeMap<_, _> = stream.turns().map(|turn| (turn.turn, robots_of(turn))).collect();
    let broken = stream.steps().find_map(|step| {
        let asked = turns.get(&step.turn)?;
        let given: BTreeSet<_> = step.robots.iter().map(|part| part.robot).collect();
        (*asked != given)
            .then(|| format!("Turn {} has the robots {asked:?}, and its Step has {given:?}", step.turn))
    });
    unless(broken)
}

pub(crate) fn sets_no_thinking_time(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    if !stream.hello.as_ref().is_some_and(|hello| hello.thinks_as_scenario) {
        return not_used("it does not promise it");
    }
    let sets = |part: &v1::RobotStep| part.thinking_ns.is_some() || part.operations.is_some();
    unless(stream.parts().any(sets).then(|| "a Step sets thinking_ns or operations".to_owned()))
}

pub(crate) fn has_known_robots(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let robots = stream.hello.as_ref().map_or(0, |hello| hello.robots.len());
    let wrong = stream.parts().find(|part| part.robot as usize >= robots);
    unless(wrong.map(|part| format!("a Step has a robot {}, of {robots}", part.robot)))
}

pub(crate) fn sends_finite_signals(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.messages()?;
    let is_bad = |command: &v1::Command| signals(command).any(|signal| !signal.is_finite());
    unless(stream.commands().find(|(_, command)| is_bad(command)).map(|(_, command)| said(command)))
}

pub(crate) fn keeps_to_the_limit(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.messages()?;
    let limit_of = |robot: u32| sheet(stream, robot).and_then(|sheet| sheet.signal_limit);
    if limit_of(0).is_none() {
        return not_used("the motors have no limit");
    }
    let wheels = |command: &v1::Command| command.left_signal.abs().max(command.right_signal.abs());
    let over = |&(robot, command): &(u32, &v1::Command)| {
        limit_of(robot).is_some_and(|limit| wheels(command) > limit)
    };
    unless(stream.commands().find(over).map(|(_, command)| said(command)))
}

pub(crate) fn counts_other_signals(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.messages()?;
    let actuators = |robot: u32| sheet(stream, robot).map_or(0, |sheet| sheet.actuators.len());
    let is_wrong = |&(robot, command): &(u32, &v1::Command)| {
        !command.other_signals.is_empty() && command.other_signals.len() != actuators(robot)
    };
    unless(stream.commands().find(is_wrong).map(|(robot, command)| {
        format!("{} other signals for {} actuators", command.other_signals.len(), actuators(robot))
    }))
}

pub(crate) fn speaks_in_its_mode(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let is_wrong = |part: &&v1::RobotStep| match &part.output {
        Some(Output::Raw(_)) => !stream.is_raw(),
        Some(Output::Command(_) | Output::Poll(_)) => stream.is_raw(),
        None => false,
    };
    let mode = if stream.is_raw() { "RAW" } else { "MESSAGES" };
    unless(
        stream.parts().find(is_wrong).map(|_| format!("its mode is {mode}, and an output is of the other")),
    )
}

pub(crate) fn waits_for_messages(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let waits = stream.parts().filter(|part| part.until_message.is_some()).count();
    if waits > 0 { Ok(Verdict::Does) } else { not_used("it gets a Turn for each tick") }
}

pub(crate) fn waits_into_the_future(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let times: BTreeMap<_, _> = stream
        .turns()
        .flat_map(|turn| turn.robots.iter().map(|part| ((turn.turn, part.robot), part.at_ns)))
        .collect();
    let mut limits = stream.steps().flat_map(|step| step.robots.iter().map(move |part| (step.turn, part)));
    let is_past = |(turn, part): &(u64, &v1::RobotStep)| {
        let limit = part.until_message.and_then(|until| until.at_latest_ns);
        limit.zip(times.get(&(*turn, part.robot))).is_some_and(|(limit, at)| limit <= *at)
    };
    if !stream.parts().any(|part| part.until_message.is_some_and(|until| until.at_latest_ns.is_some())) {
        return not_used("it sets no such time");
    }
    unless(limits.find(is_past).map(|(turn, _)| format!("in the answer to Turn {turn} that time is over")))
}

pub(crate) fn needs_no_memory_off_board(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let is_onboard = sheet(stream, 0).is_some_and(|sheet| sheet.onboard);
    match stream.hello.as_ref().and_then(|hello| hello.memory_bytes) {
        None => not_used("it names no memory"),
        Some(_) => unless((!is_onboard).then(|| "its brain does not run on board".to_owned())),
    }
}

pub(crate) fn publishes_soundly(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let mut beliefs = stream
        .events
        .iter()
        .filter_map(|event| match event {
            Event::Annotate(annotate) => annotate.belief.as_ref(),
            Event::BeforeHello
            | Event::SecondHello
            | Event::BeforeWelcome
            | Event::Turn(_)
            | Event::Step(..)
            | Event::Reset
            | Event::Ended
            | Event::Closed => None,
        })
        .peekable();
    if beliefs.peek().is_none() {
        return not_used("it publishes nothing");
    }
    unless(beliefs.any(|belief| !is_finite(belief)).then(|| "a number of a belief is not finite".to_owned()))
}

pub(crate) fn drives_both(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let outputs =
        |robot: u32| stream.parts().filter(|part| part.robot == robot && part.output.is_some()).count();
    unless(
        (outputs(1) == 0)
            .then(|| format!("the first robot gets {} outputs, and the second none", outputs(0))),
    )
}

pub(crate) fn leaves_out_the_omitted(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let turns: BTreeMap<_, _> = stream.turns().map(|turn| (turn.turn, robots_of(turn))).collect();
    if turns.values().all(|robots| robots.len() == 2) {
        return not_used("no Turn omits a robot");
    }
    let extra = stream.steps().find_map(|step| {
        let asked = turns.get(&step.turn)?;
        let part = step.robots.iter().find(|part| !asked.contains(&part.robot))?;
        Some(format!("the answer to Turn {} has robot {}, which the Turn omits", step.turn, part.robot))
    });
    unless(extra)
}

pub(crate) fn goes_by_the_data_sheet(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.messages()?;
    let (own, plain) = (commands(stream), seen.plain.first().map(commands).unwrap_or_default());
    let differs = own.iter().zip(&plain).position(|(own, plain)| own != plain);
    unless(match differs {
        Some(place) => Some(format!("its command {} is not the one of the run without this", place + 1)),
        None if own.len() != plain.len() => {
            Some(format!("it sends {} commands in place of {}{}", own.len(), plain.len(), seen.ended()))
        }
        None => None,
    })
}

pub(crate) fn drives_again_alike(seen: &Evidence<'_>) -> Judgement {
    seen.stream()?;
    match (&seen.record.state_hash, &seen.plain.state_hash) {
        (Some(own), Some(plain)) => unless((own != plain).then(|| {
            "the same run ends in another state: it uses the time of day, or numbers that BAUDBOT_SEED does not fix".to_owned()
        })),
        _ => not_used("the world is gone"),
    }
}

pub(crate) fn answers_in_bursts(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    let steps = stream.steps().count();
    unless(
        (steps == 0).then(|| format!("it answers none of {} Turns{}", stream.turns().count(), seen.ended())),
    )
}

pub(crate) fn does_not_flood(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    // Turns that a slow brain has not come to are none of its Steps' matter.
    let answered: BTreeSet<u64> = stream.steps().map(|step| step.turn).filter(|turn| *turn > 0).collect();
    let (steps, answered) = (stream.steps().count(), answered.len());
    unless((steps > 4 * answered.max(1)).then(|| format!("{steps} Steps come for {answered} Turns")))
}

pub(crate) fn survives_split_bytes(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.stream()?;
    if !stream.is_raw() {
        return not_used("the server decodes for it");
    }
    match seen.drove_on(stream)? {
        Verdict::Does => unless((stream.outputs() == 0).then(|| "it writes nothing".to_owned())),
        other @ (Verdict::DoesNot(_) | Verdict::NotUsed(_)) => Ok(other),
    }
}

/// The shortest time between commands without news: a cable may have lost the last one.
const OVERDUE_NS: u64 = 50_000_000;

/// Two commands without news between them are too many, unless the last one may be lost.
pub(crate) fn commands_on_news(seen: &Evidence<'_>) -> Judgement {
    let stream = seen.messages()?;
    let mut turns = BTreeMap::new();
    let mut last: BTreeMap<u32, u64> = BTreeMap::new();
    let (mut idle, mut all) = (0, 0);
    for event in &stream.events {
        if let Event::Turn(turn) = event {
            turns.insert(turn.turn, turn);
        }
        let Event::Step(step) = event else { continue };
        // A second answer is judged elsewhere.
        let Some(turn) = turns.remove(&step.turn) else { continue };
        for part in step.robots.iter().filter(|part| matches!(part.output, Some(Output::Command(_)))) {
            let Some(asked) = turn.robots.iter().find(|asked| asked.robot == part.robot) else { continue };
            let is_news = asked.has_message || asked.readings.iter().any(|reading| reading.readable);
            let is_due =
                last.get(&part.robot).is_none_or(|at| asked.at_ns >= at + OVERDUE_NS || asked.at_ns < *at);
            all += 1;
            idle += u64::from(!is_news && !is_due);
            last.insert(part.robot, asked.at_ns);
        }
    }
    unless(
        (idle > 0).then(|| {
            format!("{idle} of {all} commands answer Turns without a new message, and fill the cable")
        }),
    )
}

pub(crate) fn shown(seen: &Evidence<'_>, stream: &Stream) -> Judgement {
    if seen.record.end.is_none() {
        return not_used("the brain was not started by the kit, and has no token of it");
    }
    match &stream.authorization {
        None => does_not("no `authorization` comes with the call; its token is in BAUDBOT_TOKEN"),
        Some(shown) if shown.strip_prefix("Bearer ") == Some(seen.token) => Ok(Verdict::Does),
        Some(_) => does_not("the `authorization` is not `Bearer` and the token that is in BAUDBOT_TOKEN"),
    }
}

fn robots_of(turn: &v1::Turn) -> BTreeSet<u32> {
    turn.robots.iter().map(|part| part.robot).collect()
}

fn sheet(stream: &Stream, robot: u32) -> Option<&v1::RobotDescription> {
    stream.welcome.as_ref()?.robots.get(robot as usize)
}

fn signals(command: &v1::Command) -> impl Iterator<Item = f64> {
    [command.left_signal, command.right_signal].into_iter().chain(command.other_signals.iter().copied())
}

fn said(command: &v1::Command) -> String {
    let signals: Vec<_> = signals(command).map(|signal| signal.to_string()).collect();
    format!("a command has the signals {}", signals.join(", "))
}

/// The commands of a stream to the bit.
fn commands(stream: &Stream) -> Vec<(u32, Vec<u64>)> {
    stream.commands().map(|(robot, command)| (robot, signals(command).map(f64::to_bits).collect())).collect()
}

fn is_finite(belief: &v1::Belief) -> bool {
    let v1::Belief { state: _, utilities, pose, particles, path, map, motivation } = belief;
    let pose = pose.iter().flat_map(|pose| {
        [pose.x_m, pose.y_m, pose.heading_rad].into_iter().chain(pose.covariance_m2.iter().copied())
    });
    let particles =
        particles.iter().flat_map(|one| [one.x_m, one.y_m, one.heading_rad, one.weight]).map(f64::from);
    let path = path.iter().flat_map(|point| [point.x_m, point.y_m]);
    let map = map.iter().flat_map(|map| [map.x_m, map.y_m, map.cell_m]);
    pose.chain(particles)
        .chain(path)
        .chain(map)
        .chain(utilities.iter().map(|one| one.value))
        .chain(motivation.iter().flat_map(v1::Motivation::numbers))
        .all(f64::is_finite)
}

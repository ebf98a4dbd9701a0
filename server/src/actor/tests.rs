//! Worlds that follow a clock which the test sets.

use std::sync::Arc;
use std::time::{Duration, Instant};

use baudbot_brain::Action;
use baudbot_run::LockstepWorld;
use baudbot_sim::drive::Wheels;
use baudbot_sim::{Input, World};

use baudbot_proto::v1;
use futures_util::{FutureExt as _, StreamExt as _};

use tokio::sync::oneshot;

use super::{DirectWorld, NewWorld, Next, WorldActor};
use crate::endpoint::{Output, Sender, Signals};
use crate::limits::{Account, InForce, Limits};
use crate::message::{Message, Request, Watch};
use crate::pace::{Lockstep, Pace, Timed};

/// Simulated milliseconds of a tick.
const TICK_MS: u64 = 10;

fn actor(pace: Pace) -> WorldActor {
    let scenario = baudbot_scenario::parse(include_str!("../../../catalogue/scenarios/wander.toml")).unwrap();
    assert_eq!(scenario.step_ns, TICK_MS * 1_000_000);
    let new = NewWorld::new("w".into(), World::new(scenario.into()), pace);
    let charges = new.charges(&InForce::new(Limits::none())).unwrap();
    WorldActor::new("w".into(), new, charges, Arc::default())
}

/// Does what is due until this instant, each thing in no time. How many ticks that were.
fn go_on(actor: &mut WorldActor, now: &mut Instant, until: Instant) -> u64 {
    let before = actor.world.tick();
    loop {
        match actor.next(*now) {
            Next::Begin => actor.begin(*now),
            Next::Finish => actor.finish_with(*now, &[]),
            Next::Wait(Some(at)) if at <= until => *now = at,
            Next::Wait(_) => break,
            Next::FinishAhead(_) | Next::End | Next::TimeOut | Next::Replay => panic!("not in real time"),
        }
    }
    *now = until;
    actor.world.tick() - before
}

#[test]
fn a_world_that_was_stopped_for_ten_seconds_works_off_a_tenth_of_a_second_and_lets_the_rest_go() {
    let (mut actor, mut now) = (actor(Pace::REAL_TIME), Instant::now());
    let second = Duration::from_secs(1);
    let until = now + second;
    assert_eq!(go_on(&mut actor, &mut now, until), 100);
    assert_eq!(actor.pacer.statistics.times_let_go, 0);
    let awake = now + 10 * second;
    now = awake;
    let at_once = go_on(&mut actor, &mut now, awake);
    assert!((10..=12).contains(&at_once), "{at_once} ticks at once");
    let let_go_ms = actor.pacer.statistics.let_go.as_millis();
    assert!((9_880..=9_900).contains(&let_go_ms), "{let_go_ms} ms");
    assert_eq!(actor.pacer.statistics.times_let_go, 1);
    // The world is on time again from here on.
    assert_eq!(go_on(&mut actor, &mut now, awake + second), 100);
    assert_eq!(actor.pacer.statistics.times_let_go, 1);
}

#[test]
fn a_world_may_be_allowed_to_work_off_more() {
    let pace = Pace::Timed(Timed { factor: 2.0, max_lag: Duration::from_secs(60) });
    let (mut actor, mut now) = (actor(pace), Instant::now());
    let until = now;
    go_on(&mut actor, &mut now, until);
    let awake = now + Duration::from_secs(5);
    now = awake;
    assert_eq!(go_on(&mut actor, &mut now, awake), 1000);
    assert_eq!((actor.pacer.statistics.times_let_go, actor.pacer.statistics.let_go), (0, Duration::ZERO));
}

#[test]
fn a_world_that_cannot_keep_up_stays_a_tenth_of_a_second_behind() {
    let (mut actor, mut now) = (actor(Pace::REAL_TIME), Instant::now());
    let started = now;
    for _ in 0..200 {
        let Next::Begin = actor.next(now) else { panic!("it is due") };
        actor.begin(now);
        now += Duration::from_millis(2 * TICK_MS);
        actor.finish_with(now, &[]);
    }
    // Four seconds went by, two were simulated.
    assert_eq!(now - started, Duration::from_secs(4));
    let behind =
        Duration::from_secs(4) - actor.pacer.statistics.let_go - Duration::from_millis(200 * TICK_MS);
    assert!(behind >= Duration::from_millis(100) && behind <= Duration::from_millis(120), "{behind:?}");
}

#[test]
fn a_world_keeps_a_short_timeline_until_somebody_looks_at_it() {
    let (mut actor, mut now) = (actor(Pace::REAL_TIME), Instant::now());
    let minute = Duration::from_secs(60);
    let until = now + minute;
    go_on(&mut actor, &mut now, until);
    let kept = |actor: &WorldActor| actor.world.robot(0).timeline().events().count();
    assert_eq!(kept(&actor), 512);
    let limits = actor.charges.limits().clone();
    let (frames, mut seen) = limits.outbox(&limits.tally(&Account::Process), "Watch", 8);
    actor.handle(Message::Watch(Watch { every_ticks: 1, details: vec![0], pins_finest_ns: None, frames }));
    let first = seen.next().now_or_never().flatten().unwrap().unwrap();
    let first: v1::WatchResponse = first.decode().unwrap();
    assert_eq!(first.details[0].events.len(), 512, "the first picture has a past");
    let until = now + minute;
    go_on(&mut actor, &mut now, until);
    assert_eq!(kept(&actor), actor.world.usual_timeline());
}

/// The caller that makes a world stand is answered when it does: the tick that has begun is over by then.
#[test]
fn a_world_stands_by_the_time_that_its_operator_is_told_so() {
    let stand = [Request::Pause, Request::SetPace(Pace::Stepped(Lockstep::default()))];
    for (request, name) in stand.into_iter().zip(["pause", "stepped"]) {
        let (mut actor, mut now) = (actor(Pace::REAL_TIME), Instant::now());
        actor.begin(now);
        let (reply, mut told) = oneshot::channel();
        actor.handle(Message::Request(request, reply));
        assert!(told.try_recv().is_err(), "{name}: the tick is not over yet");
        let until = now + Duration::from_secs(1);
        go_on(&mut actor, &mut now, until);
        let report = told.try_recv().unwrap().unwrap();
        assert_eq!((report.world.tick(), actor.world.tick()), (1, 1), "{name}");
        assert_eq!(report.beside.state(), v1::WorldState::Paused);
        // The answer about a world that stands is immediate.
        let (reply, mut told) = oneshot::channel();
        actor.handle(Message::Request(Request::Pause, reply));
        assert_eq!(told.try_recv().unwrap().unwrap().world.tick(), 1);
    }
}

/// Commands over links that take no time are handed over as such.
#[test]
fn a_world_driven_directly_is_the_one_that_the_bytes_of_its_commands_make() {
    let wander = include_str!("../../../catalogue/scenarios/wander.toml");
    let (head, cable) = wander.split_once("[robots.link]").unwrap();
    for (link, is_free) in [(cable, false), ("kind = \"ideal\"", true), ("kind = \"onboard\"", true)] {
        let head = if is_free { head.replace("receiving_us_per_byte = 5.0", "") } else { head.to_owned() };
        let scenario = Arc::new(baudbot_scenario::parse(&format!("{head}[robots.link]\n{link}")).unwrap());
        let spec = &scenario.robots[0];
        let mut by_bytes = World::new(Arc::clone(&scenario));
        let new = NewWorld::new("w".into(), by_bytes.clone(), Pace::Lockstep(Lockstep::default()));
        let mut direct = DirectWorld::start(new).unwrap();
        direct.attach("brain", &[0]);
        let mut sender = Sender::new([].into_iter(), false);
        for tick in 0..100 {
            let mut bytes = Vec::new();
            direct.begin();
            assert_eq!(direct.turns(), by_bytes.begin());
            let turn = by_bytes.turns()[0];
            let (left, right) = (0.3, 0.001 * f64::from(tick));
            let mut action = Action::wait();
            if tick % 3 > 0 {
                let signals = Signals { wheels: Wheels { left, right }, others: Vec::new() };
                bytes = sender.send(spec, Some(Output::Command(signals))).into_bytes(spec);
                assert!(!bytes.is_empty());
                action = Action::drive(left, right);
            }
            direct.act(turn, action).unwrap();
            direct.finish();
            by_bytes.finish(&[Input { robot: 0, at: turn.at + spec.thinking_ns, bytes: &bytes }]);
            assert_eq!(direct.world().hash(), by_bytes.hash(), "tick {tick} over {link}");
        }
        assert!(by_bytes.robot(0).commands() > 10, "{}", by_bytes.robot(0).commands());
    }
}

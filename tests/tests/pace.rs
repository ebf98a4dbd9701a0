//! Lockstep with brains that hang or die, and real time.

use std::time::{Duration, Instant};

use baudbot_client::{Error, Signals};
use baudbot_proto::v1;
use baudbot_server::{Pace, WatchdogPolicy};
use baudbot_tests::system::{client, drive, operator, serve, status, watched};
use baudbot_tests::{WANDER, crowd, scenario};
use tokio::task::JoinSet;

fn ten() -> Vec<String> {
    (0..10).map(|i| format!("r{i}")).collect()
}

/// Ten brains in lockstep, of which `r3` hangs after 50 turns; 300 ticks in all. How long it took.
async fn one_of_ten_hangs(policy: WatchdogPolicy) -> (Duration, v1::WorldStatus, Result<(), Error>) {
    let server = serve(scenario(&crowd(&ten()), &["end.after_s=3.0"]), watched(400, policy)).await;
    let mut brains = JoinSet::new();
    for name in ten().into_iter().filter(|name| name != "r3") {
        let client = client(&server).await;
        brains.spawn(async move { drive(&client, &name, "avoid", 1).await });
    }
    let mut hung = client(&server).await.attach("w", "r3").await.unwrap();
    let started = Instant::now();
    for _ in 0..50 {
        hung.turn().await.unwrap().unwrap();
        hung.drive(Signals { left: 0.1, right: 0.1 }).await.unwrap();
    }
    hung.turn().await.unwrap().unwrap();
    // … and here it hangs, with its stream open.
    while let Some(result) = brains.join_next().await {
        result.unwrap();
    }
    let took = started.elapsed();
    let status = status(&server).await;
    // The brain wakes up, answers the turn that it had, and asks for the next.
    let answer = hung.drive(Signals { left: 0.1, right: 0.1 }).await;
    let after = match answer {
        Ok(()) => hung.turn().await.map(|_| ()),
        Err(error) => Err(error),
    };
    server.shutdown().await;
    (took, status, after)
}

#[tokio::test]
async fn the_others_go_on_when_one_of_ten_hangs_and_only_the_declared_wait_is_lost() {
    for policy in [WatchdogPolicy::GoOn, WatchdogPolicy::Detach] {
        let (took, status, after) = one_of_ten_hangs(policy).await;
        assert_eq!(status.tick, 300, "{policy:?}");
        let pacing = status.pacing.unwrap();
        assert_eq!(pacing.watchdog_timeouts, 1, "{policy:?}: the wait was declared once");
        assert!(took >= Duration::from_millis(400), "{policy:?}: {took:?}");
        assert!(status.robots.iter().filter(|robot| robot.robot != "r3").all(|robot| robot.commands > 120));
        match policy {
            WatchdogPolicy::Detach => {
                let message = after.unwrap_err().to_string();
                assert!(message.contains("no answer to a Turn within 400ms"), "{message}");
            }
            WatchdogPolicy::Wait | WatchdogPolicy::GoOn => after.unwrap(),
        }
    }
}

#[tokio::test]
async fn with_the_policy_wait_the_world_waits_and_says_so() {
    let server = serve(scenario(WANDER, &["end.after_s=1.0"]), watched(50, WatchdogPolicy::Wait)).await;
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    let started = Instant::now();
    for _ in 0..20 {
        robot.turn().await.unwrap().unwrap();
        robot.pass().await.unwrap();
    }
    robot.turn().await.unwrap().unwrap();
    loop {
        let waiting = status(&server).await;
        assert_eq!(waiting.tick, 20);
        if waiting.pacing.unwrap().watchdog_timeouts >= 3 {
            break;
        }
        assert!(started.elapsed() < Duration::from_secs(10), "the world does not say that it waits");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert!(started.elapsed() >= Duration::from_millis(150), "{:?}", started.elapsed());
    robot.pass().await.unwrap();
    while robot.turn().await.unwrap().is_some() {
        robot.pass().await.unwrap();
    }
    assert_eq!(status(&server).await.tick, 100);
    server.shutdown().await;
}

#[tokio::test]
async fn a_brain_that_is_killed_and_restarted_goes_on_with_its_robot() {
    for policy in [WatchdogPolicy::Wait, WatchdogPolicy::GoOn] {
        let server = serve(scenario(WANDER, &["end.after_s=1.0"]), watched(10_000, policy)).await;
        let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
        for _ in 0..30 {
            robot.turn().await.unwrap().unwrap();
            robot.drive(Signals { left: 0.3, right: 0.3 }).await.unwrap();
        }
        robot.turn().await.unwrap().unwrap();
        let distance = status(&server).await.robots[0].distance_m;
        assert!(distance > 0.0);
        drop(robot);
        if policy == WatchdogPolicy::Wait {
            // The world stands still until the robot has a brain again.
            tokio::time::sleep(Duration::from_millis(100)).await;
            let waiting = status(&server).await;
            assert_eq!(waiting.state(), v1::WorldState::WaitingForBrains);
            assert_eq!(waiting.tick, 30, "the Turn that it left open waits for its successor");
        }
        let mut again = client(&server).await.attach("w", "robot").await;
        while let Err(error) = &again {
            // The old stream may take a moment to end.
            assert!(error.to_string().contains("is held by brain"), "{error}");
            tokio::time::sleep(Duration::from_millis(5)).await;
            again = client(&server).await.attach("w", "robot").await;
        }
        let mut again = again.unwrap();
        while again.turn().await.unwrap().is_some() {
            again.drive(Signals { left: 0.3, right: 0.3 }).await.unwrap();
        }
        let end = status(&server).await;
        assert_eq!(end.tick, 100);
        assert!(end.robots[0].distance_m > distance);
        server.shutdown().await;
    }
}

/// Seconds of simulated time at this pace, with what a busy machine can make worse: what was not kept, if anything.
async fn keeps_to_the_wall_clock(factor: f64, seconds: f64) -> Result<(), String> {
    let changes = [&format!("end.after_s={seconds}")[..], "collision=stop-robot"];
    let started = Instant::now();
    let server = serve(scenario(WANDER, &changes), Pace::scaled(factor)).await;
    drive(&client(&server).await, "robot", "avoid", 1).await;
    let took = started.elapsed().as_secs_f64() * factor;
    let status = status(&server).await;
    server.shutdown().await;
    let pacing = status.pacing.unwrap();
    assert_eq!(pacing.lateness_us_log2.iter().sum::<u64>(), status.tick);
    assert!(status.robots[0].distance_m > 0.3, "it drove {} m", status.robots[0].distance_m);
    // The last tick may be late on a busy machine, by the server's own measure; the rest is the clock's.
    let hiccup = pacing.lateness_max_wall_ns as f64 * 1e-9 * factor;
    let wall = status.running_wall_ns as f64 * 1e-9 * factor;
    assert!(wall > seconds * 0.99 && took > seconds * 0.8, "too fast: {wall} and {took} for {seconds}");
    // A clock that drifted would make every later tick late.
    let on_time: u64 = pacing.lateness_us_log2.iter().take(14).sum();
    let kept =
        wall < seconds * 1.01 + hiccup && took < seconds * 1.2 + hiccup && on_time * 10 > status.tick * 9;
    kept.then_some(())
        .ok_or_else(|| format!("{wall} and {took} for {seconds}: {:?}", pacing.lateness_us_log2))
}

#[tokio::test]
async fn real_time_keeps_to_the_wall_clock_and_scaled_time_to_its_multiple() {
    // The long run of 60 s is `baudbot run --pace real-time`; the drift is the same over any span, because
    // every tick's instant is computed from the start.
    for (factor, seconds) in [(1.0, 3.0), (10.0, 10.0)] {
        // A busy machine is late now and then; a wrong clock is wrong each time.
        let mut found = Vec::new();
        while let Err(late) = keeps_to_the_wall_clock(factor, seconds).await {
            found.push(late);
            assert!(found.len() < 3, "{found:#?}");
        }
    }
}

#[tokio::test]
async fn a_free_world_waits_for_nobody() {
    let server = serve(scenario(WANDER, &["end.after_s=1000.0"]), Pace::Free).await;
    let mut silent = client(&server).await.attach("w", "robot").await.unwrap();
    let started = Instant::now();
    while status(&server).await.ending.is_empty() {
        assert!(started.elapsed() < Duration::from_secs(60));
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let status = status(&server).await;
    assert_eq!((status.tick, status.robots[0].commands), (100_000, 0));
    // The brain did not read, so it lost turns, and that was counted.
    assert!(status.robots[0].lost_deliveries > 0);
    while silent.turn().await.unwrap().is_some() {}
    server.shutdown().await;
}

#[tokio::test]
async fn the_pace_can_be_changed_in_the_middle_of_a_run() {
    let server = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    let brain = client(&server).await;
    let brain = tokio::spawn(async move { drive(&brain, "robot", "avoid", 1).await });
    let mut operator = operator(&server).await;
    let mut set = async |kind| {
        let request = v1::SetPaceRequest { world: "w".into(), pace: Some(v1::Pace { kind: Some(kind) }) };
        operator.set_pace(request).await.unwrap();
    };
    for kind in [
        v1::pace::Kind::Lockstep(v1::Lockstep::default()),
        v1::pace::Kind::Scaled(v1::Scaled { factor: 5.0, max_lag_ms: 0 }),
        v1::pace::Kind::Lockstep(v1::Lockstep::default()),
        v1::pace::Kind::RealTime(v1::RealTime::default()),
    ] {
        set(kind).await;
        let before = status(&server).await.tick;
        let changed = Instant::now();
        // One tick may be under way from before; a second is of the new pace.
        while status(&server).await.tick < before + 2 {
            assert!(changed.elapsed() < Duration::from_secs(10), "the world stands still under {kind:?}");
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        assert!(status(&server).await.robots[0].attached, "the brain was thrown out under {kind:?}");
    }
    server.shutdown().await;
    brain.abort();
}

/// Answers to Turns of before a reset do not drive the new run, and do no harm.
#[tokio::test]
async fn a_backlog_of_answers_is_void_after_a_reset() {
    let server = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    // Three turns pile up while the brain thinks about the first.
    let mut last_tick = robot.turn().await.unwrap().unwrap().tick;
    tokio::time::sleep(Duration::from_millis(60)).await;
    let mut operator = operator(&server).await;
    let lockstep = v1::pace::Kind::Lockstep(v1::Lockstep::default());
    let set = v1::SetPaceRequest { world: "w".into(), pace: Some(v1::Pace { kind: Some(lockstep) }) };
    operator.pause_world(v1::PauseWorldRequest { world: "w".into() }).await.unwrap();
    operator.set_pace(set.clone()).await.unwrap();
    operator.reset_world(v1::ResetWorldRequest { world: "w".into(), ..Default::default() }).await.unwrap();
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    let full = Signals { left: 1.0, right: 1.0 };
    loop {
        robot.drive(full).await.unwrap();
        let tick = robot.turn().await.unwrap().unwrap().tick;
        if tick <= last_tick {
            break; // the first Turn of the new run
        }
        last_tick = tick;
    }
    let fresh = status(&server).await;
    assert_eq!((fresh.tick, fresh.robots[0].commands), (0, 0), "old answers were thrown away");
    // A change from lockstep to lockstep leaves the open Turn open.
    operator.set_pace(set).await.unwrap();
    tokio::time::sleep(Duration::from_millis(50)).await;
    assert_eq!(status(&server).await.tick, 0);
    robot.drive(full).await.unwrap();
    assert_eq!(robot.turn().await.unwrap().unwrap().tick, 1);
    server.shutdown().await;
}

/// A world that cannot follow an absurd scale takes commands all the same, and is sane again afterwards.
#[tokio::test]
async fn commands_to_a_world_that_lags_its_clock_do_not_go_to_the_far_future() {
    let server = serve(scenario(WANDER, &["collision=stop-robot"]), Pace::scaled(1e300)).await;
    let client = client(&server).await;
    let brain = tokio::spawn(async move { drive(&client, "robot", "avoid", 1).await });
    tokio::time::sleep(Duration::from_millis(300)).await;
    let before = status(&server).await;
    assert!(before.robots[0].commands > 0, "{:?}", before.robots[0]);
    let real_time = v1::pace::Kind::RealTime(v1::RealTime::default());
    let request = v1::SetPaceRequest { world: "w".into(), pace: Some(v1::Pace { kind: Some(real_time) }) };
    operator(&server).await.set_pace(request).await.unwrap();
    tokio::time::sleep(Duration::from_millis(300)).await;
    assert!(status(&server).await.robots[0].turns > before.robots[0].turns + 10);
    server.shutdown().await;
    brain.abort();
}

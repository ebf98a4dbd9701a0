//! Floods: of bytes, of Steps, of brains that come and go. What is too much is counted, and others are not affected.

use std::time::{Duration, Instant};

use baudbot_client::connect;
use baudbot_proto::v1;
use baudbot_proto::v1::brain_link_service_client::BrainLinkServiceClient;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_proto::v1::robot_step::Output;
use baudbot_server::Pace;
use baudbot_tests::system::{client, drive, operator, serve, serve_on_ports, status};
use baudbot_tests::{WANDER, crowd, scenario};
use futures_util::stream::unfold;
use tokio::sync::mpsc;
use tokio_stream::StreamExt;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Code;

use super::bad_input::{Stream, command, hello, messages, step};

#[tokio::test]
async fn a_flood_faster_than_any_uart_is_counted_and_the_clock_is_kept() {
    let names: Vec<String> = vec!["r0".into(), "r1".into()];
    let server = serve(scenario(&crowd(&names), &["end.after_s=2.0"]), Pace::REAL_TIME).await;
    let neighbour = client(&server).await;
    let neighbour = tokio::spawn(async move { drive(&neighbour, "r1", "avoid", 1).await });
    let flood = Stream::open(&server, hello(&["r0"], v1::PortMode::Raw)).await.unwrap();
    let started = Instant::now();
    let mut sent = 0_u64;
    while started.elapsed() < Duration::from_millis(1500) {
        let request = step(0, 0, Output::Raw(vec![0x55; 10_000]));
        // The network pushes back when the server takes no more; that is what a flood should meet.
        let sending = flood.requests.send(v1::AttachRequest { request: Some(request) });
        if tokio::time::timeout(Duration::from_millis(50), sending).await.is_ok() {
            sent += 10_000;
        }
    }
    neighbour.await.unwrap();
    let status = status(&server).await;
    let (r0, r1) = (&status.robots[0], &status.robots[1]);
    let downlink = r0.downlink.as_ref().unwrap();
    assert!(sent > 1_000_000, "{sent}");
    assert!(downlink.refused_bytes > 100_000, "{downlink:?}");
    assert!(downlink.bytes < 960 * 2 + 4096 + 100, "{downlink:?}");
    assert_eq!((r0.commands, r0.distance_m), (0, 0.0));
    assert!(r1.commands > 50 && r1.distance_m > 0.1, "the neighbour drives on: {r1:?}");
    assert_eq!(status.tick, 200);
    let pacing = status.pacing.as_ref().unwrap();
    let [wall, hiccup, let_go] = [status.running_wall_ns, pacing.lateness_max_wall_ns, pacing.let_go_wall_ns]
        .map(|ns| ns as f64 * 1e-9);
    assert!(wall > 1.9 && wall < 2.1 + hiccup + let_go, "{wall}");
    server.shutdown().await;
}

#[tokio::test]
async fn a_client_that_never_reads_loses_its_turns_and_slows_nobody() {
    let names: Vec<String> = vec!["r0".into(), "r1".into()];
    let pace = Pace::scaled(100.0);
    let server = serve(scenario(&crowd(&names), &["end.after_s=300.0"]), pace).await;
    let mute = Stream::open(&server, hello(&["r0"], v1::PortMode::Messages)).await.unwrap();
    let watcher = ObserveServiceClient::new(server.channel().await.unwrap())
        .watch(v1::WatchRequest {
            world: "w".into(),
            every_ticks: 1,
            details: Vec::new(),
            ..Default::default()
        })
        .await
        .unwrap();
    drive(&client(&server).await, "r1", "avoid", 1).await;
    let status = status(&server).await;
    assert_eq!(status.tick, 30_000, "a world that waited for it would never have come so far");
    assert!(status.robots[0].lost_deliveries > 1000, "{}", status.robots[0].lost_deliveries);
    // The observer that did not read either gets the end, and how much it missed.
    let mut frames = watcher.into_inner();
    let mut last = frames.message().await.unwrap().unwrap();
    while last.ending.is_empty() {
        last = frames.message().await.unwrap().unwrap();
    }
    assert!(last.missed_frames > 1000, "{}", last.missed_frames);
    drop(mute);
    server.shutdown().await;
}

#[tokio::test]
async fn a_brain_that_is_gone_lets_its_robot_go_even_if_it_flooded_a_world_that_stands() {
    let server = serve(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    operator(&server).await.pause_world(v1::PauseWorldRequest { world: "w".into() }).await.unwrap();
    let flood = Stream::open(&server, messages()).await.unwrap();
    for _ in 0..200 {
        flood.send(step(0, 0, command(0.1, 0.1))).await;
    }
    tokio::time::sleep(Duration::from_millis(50)).await;
    drop(flood);
    let started = Instant::now();
    while let Err(error) = Stream::open(&server, messages()).await {
        assert_eq!(error.code(), Code::AlreadyExists);
        assert!(started.elapsed() < Duration::from_secs(5), "the robot is still held: {error}");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    server.shutdown().await;
}

/// A connection over which two brains talk, of which one sends so many Steps to a world that stands, each in a frame of its
/// own, one each `pause` or as fast as they are taken.
async fn talk_to_a_world_that_stands(steps: u64, pause: Option<Duration>) {
    let names: Vec<String> = vec!["r0".into(), "r1".into()];
    let server = serve_on_ports(scenario(&crowd(&names), &[]), Pace::REAL_TIME).await;
    let mut operator = operator(&server).await;
    operator.pause_world(v1::PauseWorldRequest { world: "w".into() }).await.unwrap();
    let address = format!("http://{}", server.addresses()[1]);
    let channel = tonic::transport::Endpoint::from_shared(address).unwrap().connect().await.unwrap();
    let neighbour = baudbot_client::Client::from_channel(channel.clone());
    let mut neighbour = neighbour.attach("w", "r1").await.unwrap();
    let said = (0..steps).map(|_| step(0, 0, command(0.1, 0.1)));
    let said = std::iter::once(hello(&["r0"], v1::PortMode::Messages)).chain(said);
    let clock = pause.map(tokio::time::interval);
    let one_by_one = unfold((said, clock), async |(mut said, mut clock)| {
        match &mut clock {
            Some(clock) => _ = clock.tick().await,
            None => tokio::task::yield_now().await,
        }
        let request = Some(said.next()?);
        Some((v1::AttachRequest { request }, (said, clock)))
    });
    let (_open, end) = mpsc::channel(1);
    let requests = Box::pin(one_by_one.chain(ReceiverStream::new(end)));
    let mut responses = BrainLinkServiceClient::new(channel).attach(requests).await.unwrap().into_inner();
    // The world takes 64 in a tick, and this tick does not end.
    let (mut lost, mut since) = (0, Instant::now());
    while lost < steps - 64 {
        tokio::time::sleep(Duration::from_millis(10)).await;
        let now = status(&server).await.robots[0].lost_steps;
        if now > lost {
            (lost, since) = (now, Instant::now());
        }
        assert!(since.elapsed() < Duration::from_secs(30), "the stream is not read on: {lost} of {steps}");
    }
    let lost: Vec<_> = status(&server).await.robots.iter().map(|robot| robot.lost_steps).collect();
    assert_eq!(lost, [steps - 64, 0]);
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    for _ in 0..20 {
        neighbour.turn().await.unwrap().unwrap();
        responses.message().await.unwrap().unwrap();
    }
    server.shutdown().await;
}

#[tokio::test]
async fn a_burst_of_steps_to_a_world_that_stands_harms_nobody_on_its_connection() {
    talk_to_a_world_that_stands(4_000, None).await;
}

#[tokio::test]
async fn a_hundred_thousand_steps_to_a_world_that_stands_are_read_and_counted() {
    talk_to_a_world_that_stands(100_000, None).await;
}

#[tokio::test]
#[ignore = "ten minutes"]
async fn ten_minutes_of_a_thousand_steps_a_second_to_a_world_that_stands_are_read_and_counted() {
    talk_to_a_world_that_stands(600_000, Some(Duration::from_millis(1))).await;
}

/// The resources of this process: descriptors, and bytes of memory.
fn held() -> [usize; 2] {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    let resident: usize = pages.split(' ').nth(1).unwrap().parse().unwrap();
    [std::fs::read_dir("/proc/self/fd").unwrap().count(), resident * 4096]
}

/// Brains that come on connections of their own, take part in a tick, and go.
#[tokio::test]
#[ignore = "minutes"]
async fn after_thirty_thousand_attaches_nothing_is_left_of_them() {
    let names: Vec<String> = (0..8).map(|i| format!("r{i}")).collect();
    let server = serve_on_ports(scenario(&crowd(&names), &[]), Pace::REAL_TIME).await;
    let address = server.addresses()[0].to_string();
    let (started, mut before) = (Instant::now(), [0; 2]);
    for i in 0..30_000 {
        if i == 5_000 {
            before = held();
        }
        let client = connect(&address).await.unwrap();
        let mut robot = loop {
            match client.attach("w", &names[i % names.len()]).await {
                Ok(robot) => break robot,
                // The one before is still on its way out.
                Err(_) => tokio::time::sleep(Duration::from_millis(1)).await,
            }
        };
        if i % 100 == 0 {
            robot.turn().await.unwrap().unwrap();
        }
    }
    let took_s = started.elapsed().as_secs_f64();
    while status(&server).await.robots.iter().any(|robot| robot.attached) {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let after = held();
    println!(
        "30,000 attaches in {took_s:.0} s; descriptors and bytes: {before:?} after 5,000, {after:?} at the end"
    );
    assert!(after[0] < before[0] + 8 && after[1] < before[1] + (8 << 20), "{before:?}, {after:?}");
    server.shutdown().await;
}

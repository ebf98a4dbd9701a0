//! The bytes of a cable with their meaning, over gRPC.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use baudbot_proto::v1;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_recording::{RecordedRun, Replay};
use baudbot_server::{Server, WorldConfig};
use baudbot_tests::scenario;
use baudbot_tests::system::{client, drive, lockstep, operator, serve, status};
use tonic::{Code, Streaming};

/// A Khepera that is asked in lines, and has a laser with a cable of its own.
const KHEPERA: &str = r#"
    step_ms = 10.0
    end = { after_s = 2.0 }
    [[robots]]
    name = "k"
    preset = "khepera-1"
    link = { baud = 9600, bits_per_character = 10 }
    firmware = { protocol = "khepera" }
    brain = { thinking_us = 1000.0 }
    [robots.sensors.laser]
    kind = "laser"
    bearing_rad = 0.0
    opening_rad = 1.0
    rays = 5
    range_m = 4.0
    period_ms = 100.0
    port = { link = { kind = "uart", baud = 19200 } }
"#;

async fn watch(
    server: &Server,
    robot: &str,
    sensor: &str,
) -> Result<Streaming<v1::WatchCableResponse>, tonic::Status> {
    let mut observer = ObserveServiceClient::new(server.channel().await.unwrap());
    let (world, robot, sensor) = ("w".into(), robot.into(), sensor.into());
    let stream = observer.watch_cable(v1::WatchCableRequest { world, robot, sensor }).await?;
    Ok(stream.into_inner())
}

/// All items that come until nothing has come for a while.
async fn items(stream: &mut Streaming<v1::WatchCableResponse>) -> (Vec<v1::CableItem>, u64) {
    let (mut items, mut missed) = (Vec::new(), 0);
    while let Ok(Ok(Some(news))) = tokio::time::timeout(Duration::from_millis(500), stream.message()).await {
        items.extend(news.items);
        missed = news.missed_items;
    }
    (items, missed)
}

fn find<'a>(items: &'a [v1::CableItem], begin: &str) -> &'a v1::CableItem {
    let found = items.iter().find(|item| item.text.starts_with(begin));
    found.unwrap_or_else(|| panic!("no `{begin}` in {items:?}"))
}

#[tokio::test]
async fn a_watcher_gets_the_bytes_of_a_cable_with_their_meaning_and_changes_nothing() {
    let alone = serve(scenario(KHEPERA, &[]), lockstep()).await;
    drive(&client(&alone).await, "k", "constant", 1).await;
    let server = serve(scenario(KHEPERA, &[]), lockstep()).await;
    // One that does not read, and one that has gone.
    let _deaf = watch(&server, "k", "").await.unwrap();
    drop(watch(&server, "k", "laser").await.unwrap());
    let mut robot = watch(&server, "k", "").await.unwrap();
    let mut laser = watch(&server, "", "laser").await.unwrap();
    let first = robot.message().await.unwrap().unwrap();
    assert_eq!((first.items.len(), first.missed_items, first.restarted), (0, 0, false));
    drive(&client(&server).await, "k", "constant", 1).await;
    assert_eq!(status(&server).await.state_hash, status(&alone).await.state_hash);

    let (said, missed) = items(&mut robot).await;
    assert_eq!(missed, 0);
    let question = find(&said, "N: ask proximity");
    assert_eq!(
        (question.direction(), question.data.as_slice(), question.size),
        (v1::CableDirection::Down, &b"N\r"[..], 2)
    );
    let answer = find(&said, "n: proximity ");
    assert_eq!(answer.direction(), v1::CableDirection::Up);
    assert!(answer.data.starts_with(b"n,") && answer.data.ends_with(b"\r\n") && answer.understood);
    assert!(answer.from_ns > question.to_ns && answer.to_ns > answer.from_ns, "{answer:?}");
    find(&said, "d: speed set");
    let (scans, _) = items(&mut laser).await;
    let scan = find(&scans, "MD");
    assert!(scan.text.ends_with("5 distances, checksums right") && scan.age_ns.is_some(), "{scan:?}");
    assert_eq!(scan.direction(), v1::CableDirection::Up);
}

#[tokio::test]
async fn a_reset_is_told() {
    let server = serve(scenario(KHEPERA, &[]), lockstep()).await;
    let mut robot = watch(&server, "k", "").await.unwrap();
    drive(&client(&server).await, "k", "constant", 1).await;
    let reset = v1::ResetWorldRequest { world: "w".into(), ..Default::default() };
    operator(&server).await.reset_world(reset).await.unwrap();
    drive(&client(&server).await, "k", "constant", 1).await;
    let mut news = Vec::new();
    while let Ok(Ok(Some(next))) = tokio::time::timeout(Duration::from_millis(500), robot.message()).await {
        news.push(next);
    }
    assert_eq!(news.iter().filter(|news| news.restarted).count(), 1);
    let after = news.iter().position(|news| news.restarted).unwrap();
    let first =
        |news: &[v1::WatchCableResponse]| news.iter().flat_map(|news| news.items.clone()).next().unwrap();
    assert_eq!(first(&news[after..]), first(&news[..after]), "the run begins again");
}

#[tokio::test]
async fn a_replay_has_the_bytes_of_its_recording() {
    let file = std::env::temp_dir().join(format!("baudbot-cables-{}.mcap", std::process::id()));
    let _ = std::fs::remove_file(&file);
    let world =
        WorldConfig::new("w", scenario(KHEPERA, &[])).pace(lockstep()).record(PathBuf::from(&file), 0.0);
    let server = Server::builder().world(world).in_process().await.unwrap();
    let mut live = watch(&server, "k", "").await.unwrap();
    drive(&client(&server).await, "k", "constant", 1).await;
    let (live, _) = items(&mut live).await;
    server.shutdown().await;
    let recorded = Arc::new(RecordedRun::open(&file).unwrap());
    let world = WorldConfig::replay("w", Replay::start(recorded).unwrap()).pace(lockstep());
    let server = Server::builder().world(world).in_process().await.unwrap();
    let mut replayed = watch(&server, "k", "").await.unwrap();
    let start = v1::StartWorldRequest { world: "w".into() };
    operator(&server).await.start_world(start).await.unwrap();
    let (replayed, _) = items(&mut replayed).await;
    let texts = |items: &[v1::CableItem]| items.iter().map(|item| item.text.clone()).collect::<Vec<_>>();
    let (live, replayed) = (texts(&live), texts(&replayed));
    assert!(!replayed.is_empty() && live.starts_with(&replayed), "{live:?} {replayed:?}");
    server.shutdown().await;
    let _ = std::fs::remove_file(&file);
}

#[tokio::test]
async fn a_cable_that_there_is_not_is_refused_with_its_field() {
    let server = serve(scenario(KHEPERA, &[]), lockstep()).await;
    for (robot, sensor, code, text) in [
        ("nobody", "", Code::NotFound, "robot: there is no robot `nobody`; there are: k"),
        ("k", "nothing", Code::NotFound, "sensor: `k` has no sensor `nothing`"),
        ("k", "ir_0", Code::FailedPrecondition, "sensor: `ir_0` has no cable of its own"),
    ] {
        let status = watch(&server, robot, sensor).await.unwrap_err();
        assert_eq!((status.code(), status.message()), (code, text));
    }
}

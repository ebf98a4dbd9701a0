//! A server without threads goes by the clock of its runtime.

use std::time::Duration;

use baudbot_client::Signals;
use baudbot_proto::v1;
use baudbot_server::{Pace, Server, WatchdogPolicy, WorldConfig};
use baudbot_tests::system::{client, operator, status, watched};
use baudbot_tests::{WANDER, scenario};
use tokio::time::{Instant, sleep, timeout};

async fn serve(pace: Pace, changes: &[&str]) -> Server {
    let world = WorldConfig::new("w", scenario(WANDER, changes)).pace(pace);
    Server::builder().world(world).without_threads().in_process().await.unwrap()
}

#[tokio::test(start_paused = true)]
async fn a_minute_in_real_time_is_a_minute_of_the_paused_clock() {
    let server = serve(Pace::REAL_TIME, &[]).await;
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    let began = Instant::now();
    while began.elapsed() < Duration::from_secs(60) {
        robot.turn().await.unwrap().unwrap();
        robot.drive(Signals { left: 0.1, right: -0.1 }).await.unwrap();
    }
    let status = status(&server).await;
    assert!((5998..=6002).contains(&status.tick), "{}", status.tick);
    assert_eq!(status.pacing.unwrap().late_ticks, 0);
    assert!(status.robots[0].commands > 2000, "{:?}", status.robots[0]);
    server.shutdown().await;
}

#[tokio::test(start_paused = true)]
async fn a_watchdog_acts_in_its_time() {
    let server = serve(watched(30_000, WatchdogPolicy::Detach), &[]).await;
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    let began = Instant::now();
    robot.turn().await.unwrap().unwrap();
    sleep(Duration::from_secs(20)).await;
    robot.drive(Signals { left: 0.1, right: 0.1 }).await.unwrap();
    robot.turn().await.unwrap().unwrap();
    sleep(Duration::from_secs(40)).await;
    let text = robot.turn().await.unwrap_err().to_string();
    assert!(text.contains("no answer to a Turn within 30s"), "{text}");
    assert_eq!(began.elapsed(), Duration::from_secs(60));
    server.shutdown().await;
}

#[tokio::test(start_paused = true)]
async fn a_free_world_lets_no_paused_time_pass_and_others_have_their_turn() {
    let server = serve(Pace::Free, &["end.after_s=100.0"]).await;
    let began = Instant::now();
    let mut seen = 0;
    while status(&server).await.ending.is_empty() {
        seen += 1;
    }
    assert!(seen > 1, "an operator is answered while it runs");
    assert!(began.elapsed() < Duration::from_secs(1), "{:?}", began.elapsed());
    server.shutdown().await;
}

#[tokio::test(start_paused = true)]
async fn worlds_that_are_deleted_and_a_server_that_stops_leave_no_tasks() {
    let metrics = tokio::runtime::Handle::current().metrics();
    let before = metrics.num_alive_tasks();
    let server = serve(Pace::REAL_TIME, &[]).await;
    let mut operator = operator(&server).await;
    for _ in 0..3 {
        let new = v1::CreateWorldRequest {
            world: "new".into(),
            scenario_toml: WANDER.into(),
            ..Default::default()
        };
        operator.create_world(new).await.unwrap();
        sleep(Duration::from_secs(1)).await;
        operator.delete_world(v1::DeleteWorldRequest { world: "new".into() }).await.unwrap();
    }
    drop(operator);
    timeout(Duration::from_secs(60), server.shutdown()).await.unwrap();
    sleep(Duration::from_secs(1)).await;
    assert_eq!(metrics.num_alive_tasks(), before);
}

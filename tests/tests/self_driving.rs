//! Robots that programs of the user's own drive, in worlds that wait for brains.

use std::path::Path;

use baudbot_proto::v1;
use baudbot_server::{Lockstep, Pace, Server};
use baudbot_sim::Scenario;
use baudbot_tests::scenario;
use baudbot_tests::system::{client, drive, lockstep, operator, serve, status};
use tonic::Status;

/// A robot with a program whose bytes are unknown, for so many seconds.
pub(crate) fn alone(seconds: f64) -> Scenario {
    self_driving("", &[&format!("end.after_s={seconds:?}")])
}

/// The same with another robot that a brain drives.
pub(crate) fn with_another(seconds: f64) -> Scenario {
    let other = r#"
        [[robots]]
        name = "other"
        start = { x_m = 1.2, y_m = 1.2, heading_rad = 0.0 }
        body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
    "#;
    self_driving(other, &[&format!("end.after_s={seconds:?}")])
}

fn self_driving(more: &str, changes: &[&str]) -> Scenario {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios"));
    let text =
        baudbot_import::inline(include_str!("../../catalogue/scenarios/firmware.toml"), folder).unwrap();
    scenario(&(text + more), changes)
}

async fn step(server: &Server, ticks: u64) -> Result<(), Status> {
    let request = v1::StepWorldRequest { world: "w".into(), ticks };
    operator(server).await.step_world(request).await.map(|_| ())
}

/// The tick at which the world stands when its run is over.
async fn over(server: &Server) -> u64 {
    loop {
        let status = status(server).await;
        if status.state() == v1::WorldState::Ended {
            return status.tick;
        }
        tokio::time::sleep(std::time::Duration::from_millis(10)).await;
    }
}

#[tokio::test]
async fn no_world_waits_for_a_brain_of_a_robot_that_drives_itself() {
    let server = serve(alone(0.5), lockstep()).await;
    assert_eq!(over(&server).await, 50);
    server.shutdown().await;
    let server = serve(alone(0.5), Pace::Stepped(Lockstep::default())).await;
    step(&server, 20).await.unwrap();
    assert_eq!(status(&server).await.tick, 20);
    server.shutdown().await;
}

#[tokio::test]
async fn a_world_waits_for_the_brains_of_the_others() {
    let stepped = serve(with_another(0.5), Pace::Stepped(Lockstep::default())).await;
    let refused = step(&stepped, 1).await.unwrap_err();
    assert!(refused.message().contains("a robot has no brain"), "{refused:?}");
    stepped.shutdown().await;
    let server = serve(with_another(0.5), lockstep()).await;
    assert_eq!(status(&server).await.state(), v1::WorldState::WaitingForBrains);
    drive(&client(&server).await, "other", "constant", 1).await;
    assert_eq!(over(&server).await, 50);
    server.shutdown().await;
}

#[tokio::test]
async fn who_attaches_to_the_cable_of_such_a_robot_is_waited_for() {
    let server = serve(alone(0.5), Pace::Stepped(Lockstep::default())).await;
    step(&server, 10).await.unwrap();
    let mut laptop = client(&server).await.attach_raw("w", "robot").await.unwrap();
    let (mut text, mut asked) = (Vec::new(), 0);
    let listening = async {
        while let Some(turn) = laptop.turn().await.unwrap() {
            asked += 1;
            text.extend(turn.bytes);
            laptop.write(&[]).await.unwrap();
        }
    };
    let stepping = async {
        step(&server, 40).await.unwrap();
        assert_eq!(over(&server).await, 50);
    };
    tokio::join!(listening, stepping);
    assert_eq!(asked, 40, "once a tick");
    let text = String::from_utf8(text).unwrap();
    assert!(text.lines().count() >= 3 && text.lines().skip(1).all(|line| line.contains(' ')), "{text}");
    server.shutdown().await;
}

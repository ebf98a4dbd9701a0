//! Changes that an operator makes by hand in a world of a server.

use std::time::Duration;

use baudbot_client::{Belief, Error, GridMap, Robot, Signals, Utility};
use baudbot_proto::v1;
use baudbot_proto::v1::brain_link_service_client::BrainLinkServiceClient;
use baudbot_proto::v1::intervene_request::Intervention;
use baudbot_server::{Lockstep, Pace, Server, WatchdogPolicy};
use baudbot_tests::system::{client, lockstep, operator, serve, status, watched};
use baudbot_tests::{WANDER, scenario};
use tokio_stream::StreamExt;
use tonic::Code;

async fn intervene(server: &Server, intervention: Intervention) -> Result<v1::WorldStatus, tonic::Status> {
    let request = v1::InterveneRequest { world: "w".into(), intervention: Some(intervention) };
    let response = operator(server).await.intervene(request).await?;
    Ok(response.into_inner().status.expect("a status"))
}

fn pull(pulled: bool) -> Intervention {
    Intervention::PullCable(v1::PullCable { robot: "robot".into(), pulled })
}

fn place(x_m: f64, y_m: f64) -> Intervention {
    Intervention::PlaceRobot(v1::PlaceRobot { robot: "robot".into(), x_m, y_m, heading_rad: 0.0 })
}

fn detach(restart: bool) -> Intervention {
    Intervention::DetachBrain(v1::DetachBrain { robot: "robot".into(), restart })
}

#[tokio::test]
async fn a_change_within_a_tick_waits_for_its_end() {
    let server = serve(scenario(WANDER, &[]), lockstep()).await;
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    let first = robot.turn().await.unwrap().unwrap();
    let changed = intervene(&server, place(0.1, 0.2));
    let mut changed = Box::pin(changed);
    let soon = Duration::from_millis(50);
    assert!(tokio::time::timeout(soon, changed.as_mut()).await.is_err(), "the tick has begun");
    robot.drive(Signals { left: 0.0, right: 0.0 }).await.unwrap();
    assert_eq!(changed.await.unwrap().tick, first.tick + 1);
    server.shutdown().await;
}

#[tokio::test]
async fn a_reset_forgets_what_was_to_be_changed() {
    let server = serve(scenario(WANDER, &[]), lockstep()).await;
    let begun = status(&server).await.state_hash;
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    robot.turn().await.unwrap().unwrap();
    let mut changed = Box::pin(intervene(&server, place(0.1, 0.2)));
    let soon = Duration::from_millis(50);
    assert!(tokio::time::timeout(soon, changed.as_mut()).await.is_err(), "the tick has begun");
    let mut operator = operator(&server).await;
    operator.pause_world(v1::PauseWorldRequest { world: "w".into() }).await.unwrap();
    operator.reset_world(v1::ResetWorldRequest { world: "w".into(), ..Default::default() }).await.unwrap();
    assert_eq!(changed.await.unwrap_err().code(), Code::Aborted);
    assert_eq!(status(&server).await.state_hash, begun);
    server.shutdown().await;
}

#[tokio::test]
async fn a_state_that_was_kept_within_a_tick_is_changed_after_it() {
    let server = serve(scenario(WANDER, &[]), lockstep()).await;
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    robot.turn().await.unwrap().unwrap();
    let mut operator = operator(&server).await;
    let kept = operator.snapshot_world(v1::SnapshotWorldRequest { world: "w".into() }).await.unwrap();
    let snapshot = kept.into_inner().snapshot;
    operator.pause_world(v1::PauseWorldRequest { world: "w".into() }).await.unwrap();
    operator.restore_world(v1::RestoreWorldRequest { world: "w".into(), snapshot }).await.unwrap();
    let refused = intervene(&server, place(0.1, 0.2)).await.unwrap_err();
    assert!(refused.message().ends_with("it can be changed after a step"), "{refused:?}");
    drop(robot);
    let tick = status(&server).await.tick;
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    // The brain has to be gone before the world goes on.
    while status(&server).await.tick == tick {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    intervene(&server, place(0.1, 0.2)).await.unwrap();
    server.shutdown().await;
}

#[tokio::test]
async fn beliefs_have_limits_that_are_told() {
    let server = serve(scenario(WANDER, &[]), Pace::Free).await;
    let client = client(&server).await;
    let refusal = async |belief: Belief| {
        let mut robot = client.attach("w", "robot").await.unwrap();
        robot.publish(Belief { state: "fine".into(), ..Belief::default() }).await.unwrap();
        let _ = robot.publish(belief).await;
        loop {
            match robot.turn().await {
                Ok(Some(_)) => {}
                Ok(None) => panic!("no reason"),
                Err(error) => break error.to_string(),
            }
        }
    };
    let long = refusal(Belief { state: "x".repeat(300_000), ..Belief::default() }).await;
    assert!(long.contains("annotate.belief: has 300004 bytes, the limit is 262144"), "{long}");
    let many = refusal(Belief { utilities: vec![Utility::default(); 257], ..Belief::default() }).await;
    assert!(many.contains("annotate.belief.utilities: there are 257, the limit is 256"), "{many}");
    let map = GridMap { columns: 3, cells: vec![0; 10], ..GridMap::default() };
    let askew = refusal(Belief { map: Some(map), ..Belief::default() }).await;
    assert!(askew.contains("10 cells in 3 columns are not a grid"), "{askew}");
    server.shutdown().await;
}

#[tokio::test]
async fn what_cannot_be_is_refused_with_a_reason() {
    let server = serve(scenario(WANDER, &[]), Pace::Stepped(Lockstep::default())).await;
    let refused = async |intervention| {
        let status = intervene(&server, intervention).await.unwrap_err();
        (status.code(), status.message().to_owned())
    };
    let (code, text) = refused(place(1e9, 0.0)).await;
    assert_eq!(
        (code, text.as_str()),
        (Code::InvalidArgument, "intervention: x_m: must be a number from -1000000 to 1000000")
    );
    let nobody = v1::PullCable { robot: "nobody".into(), pulled: true };
    let (code, text) = refused(Intervention::PullCable(nobody)).await;
    assert_eq!((code, text.as_str()), (Code::NotFound, "intervention: robot: there is no robot `nobody`"));
    let empty = v1::InterveneRequest { world: "w".into(), intervention: None };
    let status = operator(&server).await.intervene(empty).await.unwrap_err();
    assert_eq!((status.code(), status.message()), (Code::InvalidArgument, "intervention: must be set"));
    for restart in [false, true] {
        let (code, text) = refused(detach(restart)).await;
        assert_eq!(
            (code, text.as_str()),
            (Code::FailedPrecondition, "detach_brain.robot: robot `robot` has no brain")
        );
    }
    server.shutdown().await;
}

#[tokio::test]
async fn a_pulled_cable_shows_in_the_losses_and_a_reset_plugs_it_in() {
    let server = serve(
        scenario(WANDER, &["robots.robot.link.kind=\"uart\"", "robots.robot.link.baud=115200"]),
        Pace::Free,
    )
    .await;
    intervene(&server, pull(true)).await.unwrap();
    let mut operator = operator(&server).await;
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    let lost = async || status(&server).await.robots[0].uplink.unwrap().lost_bytes;
    while lost().await < 100 {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    operator.pause_world(v1::PauseWorldRequest { world: "w".into() }).await.unwrap();
    operator.reset_world(v1::ResetWorldRequest { world: "w".into(), ..Default::default() }).await.unwrap();
    operator.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    while status(&server).await.tick < 200 {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    assert_eq!(lost().await, 0);
    server.shutdown().await;
}

/// The reason for the end of a robot's stream.
async fn ending(robot: &mut Robot) -> Error {
    loop {
        match robot.turn().await {
            Ok(Some(_)) => {}
            Ok(None) => panic!("no reason"),
            Err(error) => break error,
        }
    }
}

#[tokio::test]
async fn a_brain_that_is_thrown_off_learns_it_and_may_come_again() {
    let server = serve(scenario(WANDER, &[]), lockstep()).await;
    let client = client(&server).await;
    let mut robot = client.attach("w", "robot").await.unwrap();
    robot.turn().await.unwrap().unwrap();
    assert!(!intervene(&server, detach(false)).await.unwrap().robots[0].attached);
    let error = ending(&mut robot).await;
    assert!(matches!(error, Error::Status { code: Code::Aborted, .. }), "{error:?}");
    assert!(error.to_string().contains("the operator has detached this brain"), "{error}");
    let mut again = client.attach("w", "robot").await.unwrap();
    again.turn().await.unwrap().unwrap();
    server.shutdown().await;
}

#[tokio::test]
async fn a_brain_that_is_restarted_learns_it_and_its_robot_is_free_for_another() {
    for policy in [WatchdogPolicy::Wait, WatchdogPolicy::GoOn] {
        let server = serve(scenario(WANDER, &["end.after_s=1.0"]), watched(10_000, policy)).await;
        let client = client(&server).await;
        let mut robot = client.attach("w", "robot").await.unwrap();
        robot.turn().await.unwrap().unwrap();
        robot.pass().await.unwrap();
        let open = robot.turn().await.unwrap().unwrap();
        assert!(!intervene(&server, detach(true)).await.unwrap().robots[0].attached);
        let error = ending(&mut robot).await;
        assert!(matches!(error, Error::Restart), "{error:?}");
        if policy == WatchdogPolicy::Wait {
            tokio::time::sleep(Duration::from_millis(50)).await;
            let stands = status(&server).await;
            assert_eq!((stands.state(), stands.tick), (v1::WorldState::WaitingForBrains, open.tick));
        } else {
            while status(&server).await.ending.is_empty() {
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
        }
        let mut again = client.attach("w", "robot").await.unwrap();
        let first = again.turn().await.unwrap().map(|turn| turn.tick);
        assert_eq!(
            first,
            (policy == WatchdogPolicy::Wait).then_some(open.tick),
            "the open Turn is handed on"
        );
        server.shutdown().await;
    }
}

#[tokio::test]
async fn programs_in_any_language_find_the_reason_in_a_trailer() {
    let server = serve(scenario(WANDER, &[]), lockstep()).await;
    for (restart, reason) in [(true, Some("restart")), (false, None)] {
        let hello = v1::Hello { world: "w".into(), robots: vec!["robot".into()], ..Default::default() };
        let hello = v1::AttachRequest { request: Some(v1::attach_request::Request::Hello(hello)) };
        // The brain's side stays open.
        let requests = tokio_stream::once(hello).chain(tokio_stream::pending());
        let mut link = BrainLinkServiceClient::new(server.channel().await.unwrap());
        let mut responses = link.attach(requests).await.unwrap().into_inner();
        responses.message().await.unwrap().unwrap();
        intervene(&server, detach(restart)).await.unwrap();
        let status = loop {
            match responses.message().await {
                Ok(response) => assert!(response.is_some(), "it ends with a status"),
                Err(status) => break status,
            }
        };
        let told = status.metadata().get("baudbot-reason").map(|reason| reason.to_str().unwrap());
        assert_eq!((status.code(), told), (Code::Aborted, reason));
    }
    server.shutdown().await;
}

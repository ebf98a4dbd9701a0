//! The services as an operator and an observer use them.

use std::time::{Duration, Instant};

use baudbot_client::Signals;
use baudbot_proto::v1;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_server::{Lockstep, Pace, Server, WorldConfig};
use baudbot_sim::World;
use baudbot_tests::system::{client, lockstep, operator, serve, serve_on_ports, status};
use baudbot_tests::{ARSIM, KHEPERA, WANDER, scenario};
use tokio_stream::StreamExt;
use tonic::Code;
use tonic_health::pb::HealthCheckRequest;
use tonic_health::pb::health_client::HealthClient;
use tonic_reflection::pb::{v1 as reflection_v1, v1alpha as reflection_v1alpha};

#[tokio::test]
async fn an_operator_makes_lists_pauses_starts_and_deletes_worlds() {
    let server = Server::builder().in_process().await.unwrap();
    let mut operator = operator(&server).await;
    for toml in [WANDER, ARSIM, KHEPERA] {
        let request =
            v1::CreateWorldRequest { scenario_toml: toml.into(), paused: true, ..Default::default() };
        let status = operator.create_world(request).await.unwrap().into_inner().status.unwrap();
        assert_eq!((status.state(), status.tick), (v1::WorldState::Paused, 0));
    }
    let worlds = operator.list_worlds(v1::ListWorldsRequest {}).await.unwrap().into_inner().worlds;
    let names: Vec<_> = worlds.iter().map(|world| world.world.as_str()).collect();
    assert_eq!(names, ["arsim", "khepera", "wander"]);

    let world = || "wander".to_owned();
    operator.start_world(v1::StartWorldRequest { world: world() }).await.unwrap();
    let started = Instant::now();
    let get = || v1::GetWorldRequest { world: world() };
    while operator.get_world(get()).await.unwrap().into_inner().status.unwrap().tick <= 3 {
        assert!(started.elapsed() < Duration::from_secs(10), "the world does not start");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let paused = operator.pause_world(v1::PauseWorldRequest { world: world() }).await.unwrap();
    let paused = paused.into_inner().status.unwrap();
    assert!(paused.tick > 3, "{}", paused.tick);
    tokio::time::sleep(Duration::from_millis(100)).await;
    let later = operator.get_world(get()).await.unwrap();
    let later = later.into_inner().status.unwrap();
    assert!(later.tick <= paused.tick + 1, "a paused world finishes the tick it is in, and no more");

    operator.delete_world(v1::DeleteWorldRequest { world: world() }).await.unwrap();
    let worlds = operator.list_worlds(v1::ListWorldsRequest {}).await.unwrap().into_inner().worlds;
    assert_eq!(worlds.len(), 2);
    server.shutdown().await;
}

#[tokio::test]
async fn deleting_a_world_ends_its_streams_and_no_other() {
    let world = |name| WorldConfig::new(name, scenario(WANDER, &[])).pace(lockstep());
    let server = Server::builder().world(world("w")).world(world("v")).in_process().await.unwrap();
    let client = client(&server).await;
    let mut doomed = client.attach("w", "robot").await.unwrap();
    let mut other = client.attach("v", "robot").await.unwrap();
    doomed.turn().await.unwrap().unwrap();
    other.turn().await.unwrap().unwrap();
    operator(&server).await.delete_world(v1::DeleteWorldRequest { world: "w".into() }).await.unwrap();
    let error = doomed.turn().await.unwrap_err().to_string();
    assert!(error.contains("world `w` was deleted"), "{error}");
    for _ in 0..10 {
        other.turn().await.unwrap().unwrap();
    }
    server.shutdown().await;
}

#[tokio::test]
async fn a_stepped_world_goes_as_far_as_it_is_asked_to() {
    let server = serve(scenario(WANDER, &["end.after_s=1.0"]), Pace::Stepped(Lockstep::default())).await;
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    let brain = tokio::spawn(async move {
        while robot.turn().await.unwrap().is_some() {
            robot.drive(Signals { left: 0.2, right: 0.2 }).await.unwrap();
        }
    });
    let mut operator = operator(&server).await;
    let mut step = async |ticks| {
        let request = v1::StepWorldRequest { world: "w".into(), ticks };
        operator.step_world(request).await.map(|response| response.into_inner().status.unwrap())
    };
    assert_eq!(step(0).await.unwrap().tick, 1, "0 means 1");
    assert_eq!(step(10).await.unwrap().tick, 11);
    assert_eq!(step(0).await.unwrap().state(), v1::WorldState::Paused);
    let ended = step(1000).await.unwrap();
    assert_eq!((ended.tick, ended.state()), (100, v1::WorldState::Ended));
    assert_eq!(ended.ending, "the scenario's time is over");
    assert!(step(1).await.unwrap_err().message().contains("the run has ended"));
    brain.await.unwrap();
    server.shutdown().await;
}

#[tokio::test]
async fn a_lockstep_world_waits_for_its_first_brains_until_it_is_started() {
    let server = serve(scenario(WANDER, &["end.after_s=0.5"]), lockstep()).await;
    tokio::time::sleep(Duration::from_millis(50)).await;
    let waiting = status(&server).await;
    assert_eq!((waiting.state(), waiting.tick), (v1::WorldState::WaitingForBrains, 0));
    operator(&server).await.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    while status(&server).await.ending.is_empty() {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    assert_eq!(status(&server).await.tick, 50);
    // A brain that comes late gets the end at once.
    let mut late = client(&server).await.attach("w", "robot").await.unwrap();
    assert_eq!(late.turn().await.unwrap(), None);
    server.shutdown().await;
}

#[tokio::test]
async fn an_observer_sees_the_truth_at_its_rate() {
    let changes = ["end.after_s=1.0", "robots.robot.start.x_m=1.0", "collision=stop-robot"];
    let server = serve(scenario(WANDER, &changes), lockstep()).await;
    let mut observer = ObserveServiceClient::new(server.channel().await.unwrap());
    let world =
        observer.describe_world(v1::DescribeWorldRequest { world: "w".into() }).await.unwrap().into_inner();
    assert_eq!((world.polygons.len(), world.circles.len()), (6, 0));
    assert_eq!(world.robots[0].sensor_columns[2], "ir_front");
    let watch =
        v1::WatchRequest { world: "w".into(), every_ticks: 10, details: Vec::new(), ..Default::default() };
    let mut frames = observer.watch(watch).await.unwrap().into_inner();
    let first = frames.message().await.unwrap().unwrap();
    assert_eq!((first.tick, first.robots[0].x_m), (0, 1.0));

    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    let mut seen = Vec::new();
    while robot.turn().await.unwrap().is_some() {
        robot.drive(Signals { left: 1.0, right: 1.0 }).await.unwrap();
    }
    while let Some(frame) = frames.next().await {
        let frame = frame.unwrap();
        let over = !frame.ending.is_empty();
        seen.push(frame);
        if over {
            break;
        }
    }
    let ticks: Vec<_> = seen.iter().map(|frame| frame.tick).collect();
    let missed = seen.last().unwrap().missed_frames;
    assert!(ticks.iter().all(|tick| tick % 10 == 0), "{ticks:?}");
    assert_eq!(ticks.len() as u64 + missed, 11, "{ticks:?}");
    let last = seen.last().unwrap();
    assert_eq!(last.ending, "the scenario's time is over");
    let collisions: Vec<_> = seen.iter().flat_map(|frame| &frame.collisions).collect();
    assert_eq!(collisions, [&v1::Collision { robot: "robot".into(), with: "wall_right".into() }]);
    assert!(last.robots[0].collided && last.robots[0].x_m < 1.6);
    assert!(last.robots[0].samples[2] > 0.9, "a wall is right ahead: {:?}", last.robots[0].samples);
    server.shutdown().await;
}

#[tokio::test]
async fn health_and_reflection_answer_over_tcp() {
    let server = serve_on_ports(scenario(WANDER, &[]), Pace::REAL_TIME).await;
    let address = format!("http://{}", server.addresses()[1]);
    let channel = tonic::transport::Endpoint::from_shared(address).unwrap().connect().await.unwrap();
    for service in
        ["", "baudbot.v1.ControlService", "baudbot.v1.BrainLinkService", "baudbot.v1.ObserveService"]
    {
        let request = HealthCheckRequest { service: service.into() };
        let health = HealthClient::new(channel.clone()).check(request).await.unwrap().into_inner();
        assert_eq!(health.status, 1, "{service}");
    }
    use reflection_v1::server_reflection_request::MessageRequest;
    use reflection_v1::server_reflection_response::MessageResponse;
    let request = reflection_v1::ServerReflectionRequest {
        host: String::new(),
        message_request: Some(MessageRequest::ListServices(String::new())),
    };
    let mut client = reflection_v1::server_reflection_client::ServerReflectionClient::new(channel.clone());
    let mut answers = client.server_reflection_info(tokio_stream::once(request)).await.unwrap().into_inner();
    let Some(MessageResponse::ListServicesResponse(list)) =
        answers.message().await.unwrap().unwrap().message_response
    else {
        panic!("a list of services")
    };
    let names: Vec<_> = list.service.iter().map(|service| service.name.as_str()).collect();
    assert!(names.contains(&"baudbot.v1.BrainLinkService"), "{names:?}");
    // The older protocol, the only one that Python's client speaks.
    let request = reflection_v1alpha::ServerReflectionRequest {
        host: String::new(),
        message_request: Some(reflection_v1alpha::server_reflection_request::MessageRequest::ListServices(
            String::new(),
        )),
    };
    let mut client = reflection_v1alpha::server_reflection_client::ServerReflectionClient::new(channel);
    let mut answers = client.server_reflection_info(tokio_stream::once(request)).await.unwrap().into_inner();
    assert!(answers.message().await.unwrap().unwrap().message_response.is_some());
    server.shutdown().await;
}

#[tokio::test]
async fn two_hundred_worlds_and_their_brains_live_in_one_server() {
    let mut builder = Server::builder();
    for i in 0..200 {
        builder = builder.world(
            WorldConfig::new(format!("w{i}"), scenario(WANDER, &["end.after_s=0.2"])).pace(lockstep()),
        );
    }
    let server = builder.in_process().await.unwrap();
    let client = client(&server).await;
    let mut brains = tokio::task::JoinSet::new();
    for i in 0..200 {
        let client = client.clone();
        brains.spawn(async move {
            let mut robot = client.attach(&format!("w{i}"), "robot").await.unwrap();
            let mut turns = 0;
            while robot.turn().await.unwrap().is_some() {
                turns += 1;
            }
            turns
        });
    }
    while let Some(turns) = brains.join_next().await {
        assert_eq!(turns.unwrap(), 20);
    }
    server.shutdown().await;
}

#[tokio::test]
async fn ticks_that_nobody_waits_for_any_more_are_not_done() {
    let server = serve(scenario(WANDER, &["collision=stop-robot"]), Pace::Stepped(Lockstep::default())).await;
    let mut first = operator(&server).await;
    let mut second = operator(&server).await;
    first.start_world(v1::StartWorldRequest { world: "w".into() }).await.unwrap();
    let step = |ticks| v1::StepWorldRequest { world: "w".into(), ticks };
    let endless = tokio::spawn(async move { first.step_world(step(u64::MAX)).await.map(drop) });
    while status(&server).await.tick < 10 {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    // A second order has no place beside it, and gets an error.
    let refused = second.step_world(step(1)).await.unwrap_err();
    assert_eq!(refused.code(), Code::FailedPrecondition);
    assert!(refused.message().contains("`w` is running another StepWorld"), "{}", refused.message());
    endless.abort();
    let started = Instant::now();
    while status(&server).await.state() != v1::WorldState::Paused {
        assert!(started.elapsed() < Duration::from_secs(20), "it goes on though its client is gone");
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    let stopped = status(&server).await.tick;
    let stepped = second.step_world(step(3)).await.unwrap().into_inner().status.unwrap();
    assert_eq!(stepped.tick, stopped + 3);
    server.shutdown().await;
}

#[tokio::test]
async fn a_world_whose_looker_on_panics_ends_its_brains_streams_with_the_reason() {
    let panics = Box::new(|world: &World| assert!(world.tick() < 5, "this panic is part of a test"));
    let world = WorldConfig::new("w", scenario(WANDER, &[])).pace(lockstep()).on_tick(panics);
    let server = Server::builder().world(world).in_process().await.unwrap();
    let mut robot = client(&server).await.attach("w", "robot").await.unwrap();
    let error = loop {
        match robot.turn().await {
            Ok(turn) => assert!(turn.is_some()),
            Err(error) => break error.to_string(),
        }
        robot.pass().await.unwrap();
    };
    assert!(error.contains("world `w` has ended with a panic"), "{error}");
    server.shutdown().await;
}

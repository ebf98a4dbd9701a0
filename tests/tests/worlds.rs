//! Many worlds on one server: they share its threads, and none keeps the others waiting.

use std::sync::mpsc;

use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_server::{Pace, Server, WorldConfig};
use baudbot_sim::World;
use baudbot_tests::system::{client, lockstep};
use baudbot_tests::{WANDER, scenario};
use tonic::transport::Channel;

/// More than any machine that runs these tests has processors to spare.
const MANY: usize = 60;

/// A server on a port with these worlds, and an operator with a connection to it.
async fn on_a_port(worlds: impl IntoIterator<Item = WorldConfig>) -> (Server, ControlServiceClient<Channel>) {
    let builder = worlds.into_iter().fold(Server::builder(), baudbot_server::Builder::world);
    let server = builder.listen("127.0.0.1:0".parse().unwrap()).serve().await.unwrap();
    let address = format!("http://{}", server.addresses()[0]);
    let channel = tonic::transport::Endpoint::new(address).unwrap().connect().await.unwrap();
    let operator = ControlServiceClient::new(channel);
    (server, operator)
}

fn world(name: &str, pace: Pace) -> WorldConfig {
    WorldConfig::new(name, scenario(WANDER, &[])).pace(pace)
}

fn free(count: usize) -> impl Iterator<Item = WorldConfig> {
    (0..count).map(|i| world(&format!("free-{i:02}"), Pace::Free))
}

async fn get(operator: &mut ControlServiceClient<Channel>, world: &str) -> v1::WorldStatus {
    let request = v1::GetWorldRequest { world: world.to_owned() };
    operator.get_world(request).await.unwrap().into_inner().status.unwrap()
}

async fn list(operator: &mut ControlServiceClient<Channel>) -> Vec<v1::WorldStatus> {
    operator.list_worlds(v1::ListWorldsRequest {}).await.unwrap().into_inner().worlds
}

/// Asks until all worlds have done so many ticks.
async fn until_all_have_done(operator: &mut ControlServiceClient<Channel>, ticks: u64) {
    while list(operator).await.iter().any(|world| world.tick < ticks) {}
}

#[tokio::test]
async fn worlds_that_never_rest_leave_time_to_each_other_to_the_clock_and_to_those_who_ask() {
    let clocked = ["real-1", "real-2"].map(|name| world(name, Pace::REAL_TIME));
    let (server, mut operator) = on_a_port(free(MANY).chain(clocked)).await;
    until_all_have_done(&mut operator, 50).await;
    let worlds = list(&mut operator).await;
    let names: Vec<_> = worlds.iter().map(|world| world.world.clone()).collect();
    assert!(names.len() == MANY + 2 && names.is_sorted(), "{names:?}");
    // An operator sees the effect of a request, however many other worlds run.
    let request = v1::PauseWorldRequest { world: "free-07".to_owned() };
    let paused = operator.pause_world(request).await.unwrap().into_inner().status.unwrap();
    let listed = list(&mut operator).await;
    for status in [&get(&mut operator, "free-07").await, &listed[7]] {
        assert_eq!(status.state(), v1::WorldState::Paused);
        assert!(
            (paused.tick..=paused.tick + 1).contains(&status.tick),
            "it has finished its tick, and no more"
        );
    }
    server.shutdown().await;
}

#[tokio::test]
async fn a_world_in_lockstep_gets_its_turn_beside_worlds_that_never_rest() {
    let (server, _) = on_a_port(free(MANY).chain([world("patient", lockstep())])).await;
    let mut robot = client(&server).await.attach("patient", "robot").await.unwrap();
    for tick in 0..100 {
        assert_eq!(robot.turn().await.unwrap().unwrap().tick, tick);
        robot.pass().await.unwrap();
    }
    server.shutdown().await;
}

#[tokio::test]
async fn a_world_whose_hook_blocks_keeps_no_other_and_no_list_waiting() {
    let (go_on, blocked) = mpsc::channel::<()>();
    let hook = Box::new(move |_: &World| {
        // An error is the end of the blockade.
        let _ = blocked.recv();
    });
    let stuck = world("stuck", Pace::Free).paused(true).on_tick(hook);
    let (server, mut operator) = on_a_port(free(4).chain([stuck])).await;
    assert_eq!(get(&mut operator, "stuck").await.state(), v1::WorldState::Paused);
    let request = v1::StartWorldRequest { world: "stuck".to_owned() };
    operator.start_world(request).await.unwrap();
    let before: Vec<_> = list(&mut operator).await.into_iter().map(|world| world.tick).collect();
    while list(&mut operator).await.iter().zip(&before).take(4).any(|(world, &before)| world.tick <= before) {
    }
    let last = list(&mut operator).await.pop().unwrap();
    assert_eq!((last.world.as_str(), last.tick), ("stuck", 0));
    drop(go_on);
    while get(&mut operator, "stuck").await.tick < 10 {}
    server.shutdown().await;
}

#[tokio::test]
async fn worlds_come_and_go_and_the_pool_outlives_them() {
    let (server, mut operator) = on_a_port(free(2)).await;
    for round in 0..50 {
        let request = v1::CreateWorldRequest {
            world: format!("guest-{round}"),
            scenario_toml: WANDER.into(),
            pace: Some(v1::Pace { kind: Some(v1::pace::Kind::Free(v1::Free {})) }),
            ..Default::default()
        };
        let world = operator.create_world(request).await.unwrap().into_inner().status.unwrap().world;
        while get(&mut operator, &world).await.tick == 0 {}
        operator.delete_world(v1::DeleteWorldRequest { world }).await.unwrap();
    }
    assert_eq!(list(&mut operator).await.len(), 2);
    until_all_have_done(&mut operator, 50).await;
    server.shutdown().await;
}

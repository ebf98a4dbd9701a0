//! Clones of worlds, over a real socket.

use baudbot_client::{Client, Signals, connect};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_server::{Address, Lockstep, Pace, Server};
use baudbot_tests::system::serve_on_ports;
use baudbot_tests::{WANDER, scenario};
use tokio::task::JoinHandle;
use tonic::transport::{Channel, Endpoint};
use tonic::{Code, Status};

type Operator = ControlServiceClient<Channel>;

/// A server with the world `w`, which is stepped; an operator and a client over TCP.
async fn serve() -> (Server, Operator, Client) {
    let server = serve_on_ports(scenario(WANDER, &[]), Pace::Stepped(Lockstep::default())).await;
    let tcp = |address: &Address| if let Address::Tcp(tcp) = address { Some(*tcp) } else { None };
    let address = server.addresses().iter().find_map(tcp).unwrap();
    let endpoint = Endpoint::new(format!("http://{address}")).unwrap();
    let operator = Operator::new(endpoint.connect().await.unwrap());
    let client = connect(&address.to_string()).await.unwrap();
    (server, operator, client)
}

/// A brain without a state, which keeps away from what is near.
async fn attach(client: &Client, world: &str) -> JoinHandle<()> {
    let mut robot = client.attach(world, "robot").await.unwrap();
    tokio::spawn(async move {
        while let Ok(Some(turn)) = robot.turn().await {
            let near = turn.value("ir_front").unwrap_or(0.0);
            robot.drive(Signals { left: 0.4, right: 0.4 - near * 0.5 }).await.unwrap();
        }
    })
}

async fn clone(operator: &mut Operator, original: &str, world: &str) -> Result<v1::WorldStatus, Status> {
    let request = v1::CloneWorldRequest { original: original.into(), world: world.into(), pace: None };
    Ok(operator.clone_world(request).await?.into_inner().status.unwrap())
}

async fn step(operator: &mut Operator, world: &str, ticks: u64) -> v1::WorldStatus {
    let request = v1::StepWorldRequest { world: world.into(), ticks };
    operator.step_world(request).await.unwrap().into_inner().status.unwrap()
}

async fn get(operator: &mut Operator, world: &str) -> v1::WorldStatus {
    let request = v1::GetWorldRequest { world: world.into() };
    operator.get_world(request).await.unwrap().into_inner().status.unwrap()
}

/// The brain is gone, and the world knows it.
async fn leave(operator: &mut Operator, world: &str, brain: JoinHandle<()>) {
    brain.abort();
    while get(operator, world).await.robots[0].attached {
        tokio::task::yield_now().await;
    }
}

#[tokio::test]
async fn a_clone_has_the_same_future_with_the_same_brain_and_leaves_the_original_alone() {
    let (server, mut operator, client) = serve().await;
    let brain = attach(&client, "w").await;
    let at_100 = step(&mut operator, "w", 100).await;
    let cloned = clone(&mut operator, "w", "what-if").await.unwrap();
    assert_eq!((cloned.tick, cloned.state_hash), (100, at_100.state_hash));
    assert_eq!((cloned.state(), cloned.robots[0].attached), (v1::WorldState::Paused, false));
    assert_eq!((&cloned.pace, &cloned.scenario), (&at_100.pace, &at_100.scenario));

    // A new brain for both: the one of the original has numbered its messages.
    leave(&mut operator, "w", brain).await;
    operator.start_world(v1::StartWorldRequest { world: "what-if".into() }).await.unwrap();
    let brains = [attach(&client, "w").await, attach(&client, "what-if").await];
    let (original, cloned) = (step(&mut operator, "w", 150).await, step(&mut operator, "what-if", 150).await);
    assert_ne!(original.state_hash, at_100.state_hash);
    assert_eq!((cloned.tick, cloned.state_hash), (250, original.state_hash));

    let pull = v1::PullCable { robot: "robot".into(), pulled: true };
    let intervention = Some(v1::intervene_request::Intervention::PullCable(pull));
    operator.intervene(v1::InterveneRequest { world: "what-if".into(), intervention }).await.unwrap();
    let changed = step(&mut operator, "what-if", 50).await;
    assert_eq!(get(&mut operator, "w").await.state_hash, original.state_hash, "the original stands still");
    assert_ne!(
        step(&mut operator, "w", 50).await.state_hash,
        changed.state_hash,
        "the clone went on without a brain"
    );
    brains.iter().for_each(JoinHandle::abort);
    server.shutdown().await;
}

#[tokio::test]
async fn a_clone_gets_a_name_and_a_pace_if_none_are_given() {
    let (server, mut operator, _) = serve().await;
    for expected in ["w-2", "w-3"] {
        assert_eq!(clone(&mut operator, "w", "").await.unwrap().world, expected);
    }
    let real_time = v1::Pace { kind: Some(v1::pace::Kind::RealTime(v1::RealTime::default())) };
    let request =
        v1::CloneWorldRequest { original: "w-2".into(), pace: Some(real_time), ..Default::default() };
    let status = operator.clone_world(request).await.unwrap().into_inner().status.unwrap();
    assert_eq!((status.world.as_str(), status.state()), ("w-2-2", v1::WorldState::Paused));
    assert!(matches!(status.pace.unwrap().kind, Some(v1::pace::Kind::RealTime(_))));
    server.shutdown().await;
}

#[tokio::test]
async fn clones_that_cannot_be_are_refused() {
    let (server, mut operator, _) = serve().await;
    for (original, world, code, text) in [
        ("v", "", Code::NotFound, "original: there is no world `v`; there are: w"),
        ("w", "w", Code::AlreadyExists, "world: there is a world `w` already"),
        ("w", "a b", Code::InvalidArgument, "world: must be 1 to 64 letters"),
    ] {
        let refused = clone(&mut operator, original, world).await.unwrap_err();
        assert_eq!(refused.code(), code, "{refused}");
        assert!(refused.message().starts_with(text), "{refused}");
    }
    let pace = Some(v1::Pace { kind: None });
    let request = v1::CloneWorldRequest { original: "w".into(), pace, ..Default::default() };
    let refused = operator.clone_world(request).await.unwrap_err();
    assert_eq!((refused.code(), refused.message()), (Code::InvalidArgument, "pace.kind: must be set"));
    server.shutdown().await;
}

//! A server and its brains over real gRPC.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use baudbot_brains::catalogue;
use baudbot_client::{Client, run};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_server::{Address, Lockstep, Pace, Server, Watchdog, WatchdogPolicy, WorldConfig};
use baudbot_sim::Scenario;
use tonic::transport::Channel;

/// Lockstep that waits for its brains.
pub fn lockstep() -> Pace {
    Pace::Lockstep(Lockstep::default())
}

/// Lockstep that asks every brain at each of its steps.
pub fn strict() -> Pace {
    Pace::Lockstep(Lockstep { lookahead: false, ..Lockstep::default() })
}

/// Lockstep with a watchdog.
pub fn watched(timeout_ms: u64, policy: WatchdogPolicy) -> Pace {
    Pace::Lockstep(Watchdog { timeout: Duration::from_millis(timeout_ms), policy }.into())
}

/// A server without ports and with one world `w`.
///
/// # Panics
/// If it does not start.
pub async fn serve(scenario: Scenario, pace: Pace) -> Server {
    let world = WorldConfig::new("w", scenario).pace(pace);
    Server::builder().world(world).in_process().await.expect("a server")
}

/// A server on a Unix socket and a TCP port, with one world `w`.
///
/// # Panics
/// If it does not start.
pub async fn serve_on_ports(scenario: Scenario, pace: Pace) -> Server {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let socket = std::env::temp_dir().join(format!("baudbot-test-{}-{number}.sock", std::process::id()));
    let world = WorldConfig::new("w", scenario).pace(pace);
    let builder = Server::builder().world(world).listen(Address::Unix(socket));
    builder.listen("127.0.0.1:0".parse().expect("an address")).serve().await.expect("a server")
}

/// A client of the server through a pipe.
///
/// # Panics
/// If it does not connect.
pub async fn client(server: &Server) -> Client {
    Client::from_channel(server.channel().await.expect("a pipe"))
}

/// An operator of the server through a pipe.
///
/// # Panics
/// If it does not connect.
pub async fn operator(server: &Server) -> ControlServiceClient<Channel> {
    ControlServiceClient::new(server.channel().await.expect("a pipe"))
}

/// The status of world `w`.
///
/// # Panics
/// If there is none.
pub async fn status(server: &Server) -> v1::WorldStatus {
    let request = v1::GetWorldRequest { world: "w".into() };
    let response = operator(server).await.get_world(request).await.expect("world `w`");
    response.into_inner().status.expect("a status")
}

/// Lets a brain of the catalogue drive a robot of world `w` until the run is over. A world without brains
/// waits for the first of each robot.
///
/// # Panics
/// If it cannot attach or is thrown out.
pub async fn drive(client: &Client, robot: &str, brain: &str, seed: u64) {
    let mut robot = client.attach("w", robot).await.expect("attached");
    let mut brain = catalogue::brain(brain, seed, robot.body()).expect("a brain of the catalogue");
    run(&mut robot, &mut brain).await.expect("a run to its end");
}

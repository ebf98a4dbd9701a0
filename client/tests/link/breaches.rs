//! A server that breaks the contract gets an error that names the breach.

use baudbot_client::{Breach, Error};
use baudbot_proto::v1::{self, attach_response::Response};

use crate::fake::Act::{Hear, Say};
use crate::fake::{at, describe, ended, serve, turn, turn_of, welcome};

fn breach<T: std::fmt::Debug>(result: Result<T, Error>) -> String {
    match result {
        Err(Error::Protocol(breach)) => breach.to_string(),
        other => panic!("no breach but {other:?}"),
    }
}

async fn attaching(script: Vec<crate::fake::Act>) -> String {
    let (client, _requests) = serve(script).await;
    breach(client.attach("room", "alice").await)
}

async fn turning(act: crate::fake::Act) -> String {
    let (client, _requests) = serve(vec![Hear, welcome(&["alice"]), act]).await;
    breach(client.attach("room", "alice").await.unwrap().turn().await)
}

fn welcome_to(change: impl FnOnce(&mut v1::RobotDescription)) -> crate::fake::Act {
    let mut described = describe("alice");
    change(&mut described);
    Say(Response::Welcome(v1::Welcome { robots: vec![described], ..v1::Welcome::default() }))
}

#[tokio::test]
async fn in_the_handshake() {
    assert_eq!(attaching(vec![Hear]).await, "expected a Welcome, got the end of the stream");
    assert_eq!(attaching(vec![Hear, ended(0)]).await, "expected a Welcome, got Ended");
    assert_eq!(attaching(vec![Hear, welcome(&["bob"])]).await, r#"asked for robots ["alice"], got ["bob"]"#);
}

#[tokio::test]
async fn in_a_body() {
    let no_firmware = welcome_to(|robot| robot.firmware = None);
    assert_eq!(attaching(vec![Hear, no_firmware]).await, "RobotDescription without its `firmware`");
    let no_encoding = welcome_to(|robot| robot.sensors[0].components[0].encoding = None);
    assert_eq!(attaching(vec![Hear, no_encoding]).await, "ComponentDescription without its `encoding`");
    let motor = |bits| {
        let signed = v1::encoding::Signed { bits, limit: 1.0 };
        let encoding = v1::Encoding { kind: Some(v1::encoding::Kind::Signed(signed)) };
        welcome_to(move |robot| robot.motor_encoding = Some(encoding))
    };
    assert_eq!(attaching(vec![Hear, motor(300)]).await, "an encoding of 300 bits");
    let text = attaching(vec![Hear, motor(40)]).await;
    assert_eq!(text, "robot `alice`: 40 bits are not possible here; the nearest that are is 32");
    let endless = welcome_to(|robot| robot.sensors[0].components[0].count = u32::MAX);
    assert!(
        attaching(vec![Hear, endless]).await.starts_with("robot `alice`: "),
        "no cable has so many values"
    );
}

#[tokio::test]
async fn in_a_turn() {
    assert_eq!(turning(welcome(&["alice"])).await, "expected a Turn or Ended, got a Welcome");
    assert_eq!(turning(turn_of(0, vec![at(0, 1)])).await, "robot 1, but there are only 1");
    let reading = |sensor, values| {
        let reading = v1::Reading { sensor, values, ..v1::Reading::default() };
        turn_of(0, vec![v1::RobotTurn { readings: vec![reading], ..at(0, 0) }])
    };
    assert_eq!(turning(reading(2, vec![])).await, "sensor 2, but there are only 2");
    assert_eq!(turning(reading(1, vec![0.0])).await, "1 values from sensor `odometer`, which has 3");
    let ports = vec![v1::PortBytes { sensor: 7, data: vec![0], after_ns: Vec::new(), baud: None }];
    let port = turn_of(0, vec![v1::RobotTurn { ports, ..at(0, 0) }]);
    assert_eq!(turning(port).await, "sensor 7, but there are only 2");
}

#[tokio::test]
async fn a_breach_is_an_error_of_its_own() {
    let (client, _requests) = serve(vec![Hear, welcome(&["alice"]), turn(0, &[0.0])]).await;
    let mut robot = client.attach("room", "alice").await.unwrap();
    assert!(robot.turn().await.is_ok());
    let breach = Breach::Missing { message: "Firmware", field: "protocol" };
    let text = Error::from(breach).to_string();
    assert_eq!(text, "the server breaks the contract `baudbot.v1`: Firmware without its `protocol`");
}

//! The page's program, as the worker calls it, on this machine.

use std::time::{Duration, Instant};

use baudbot_page::page::{ORDERS, Page};
use baudbot_proto::v1;
use baudbot_proto::v1::page_request::Request;
use baudbot_proto::v1::page_response::Response;
use baudbot_run::assignment::assign;
use baudbot_run::in_process;
use baudbot_scenario::Override;
use prost::Message;
use tempfile::TempDir;

/// The port of the page itself.
const PORT: u32 = 1;

/// A page that asks one thing after another.
struct Asks {
    page: Page,
    folder: TempDir,
    last: u32,
}

impl Asks {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let page = Page::new(folder.path().to_owned()).unwrap();
        Self { page, folder, last: 0 }
    }

    /// The next message of this port.
    fn hear(&mut self, port: u32) -> Vec<u8> {
        let deadline = Instant::now() + Duration::from_secs(120);
        while Instant::now() < deadline {
            match self.page.next_message() {
                Some((from, message)) if from == port => return message.to_vec(),
                Some(_) => {}
                None => drop(self.page.turn(Duration::from_millis(8))),
            }
        }
        panic!("nothing has come");
    }

    /// Calls a method of the operator's service.
    fn call<O: Message + Default>(&mut self, method: &str, request: &impl Message) -> Result<O, String> {
        self.last += 1;
        let call = self.last;
        let (method, request) = (format!("baudbot.v1.ControlService/{method}"), request.encode_to_vec());
        let begin = Request::Begin(v1::BeginCall { method, request });
        let request = v1::PageRequest { call, request: Some(begin) };
        self.page.take(PORT, request.encode_to_vec().into());
        let response = v1::PageResponse::decode(self.hear(PORT).as_slice()).unwrap();
        assert_eq!(response.call, call);
        match response.response {
            Some(Response::Message(message)) => Ok(O::decode(message.as_slice()).unwrap()),
            Some(Response::Failure(failure)) => Err(failure.message),
            other => panic!("{other:?}"),
        }
    }

    /// Gives an order.
    fn order(&mut self, order: &str) -> String {
        self.page.take(ORDERS, format!(r#"{{"id":7,"order":{order}}}"#).into_bytes().into());
        String::from_utf8(self.hear(ORDERS)).unwrap()
    }

    /// Makes the main job's world.
    fn wander(&mut self) -> v1::WorldStatus {
        self.wander_with(&[])
    }

    /// The same with these overrides.
    fn wander_with(&mut self, overrides: &[&str]) -> v1::WorldStatus {
        let overrides = ["end.after_s=60.0"].iter().chain(overrides);
        let kind = v1::pace::Kind::Lockstep(v1::Lockstep::default());
        let request = v1::CreateWorldRequest {
            scenario_toml: include_str!("../../../catalogue/scenarios/wander.toml").to_owned(),
            overrides: overrides.map(|&change| change.to_owned()).collect(),
            pace: Some(v1::Pace { kind: Some(kind) }),
            paused: true,
            ..v1::CreateWorldRequest::default()
        };
        self.call::<v1::CreateWorldResponse>("CreateWorld", &request).unwrap().status.unwrap()
    }

    fn run_to_the_end(&mut self) -> v1::WorldStatus {
        let world = "wander".to_owned();
        let request = v1::StartWorldRequest { world: world.clone() };
        self.call::<v1::StartWorldResponse>("StartWorld", &request).unwrap();
        loop {
            let request = v1::GetWorldRequest { world: world.clone() };
            let status = self.call::<v1::GetWorldResponse>("GetWorld", &request).unwrap().status.unwrap();
            if status.state() == v1::WorldState::Ended {
                return status;
            }
        }
    }
}

#[test]
fn the_main_job_has_the_hash_of_the_readme_and_its_recording_replays_to_it() {
    let mut asks = Asks::new();
    assert_eq!(asks.wander().world, "wander");
    let attached = asks.order(r#"{"attach":{"world":"wander","robots":["robot"],"brain":"avoid"}}"#);
    assert_eq!(attached, r#"{"id":7,"result":{"brain":"avoid"}}"#);
    let request = v1::StartRecordingRequest { world: "wander".to_owned(), ..Default::default() };
    asks.call::<v1::StartRecordingResponse>("StartRecording", &request).unwrap();
    let status = asks.run_to_the_end();
    let readme = include_str!("../../../README.md");
    let line = format!("state hash  {:016x}\n", status.state_hash);
    assert!(readme.contains(&line), "{line}");
    let request = v1::StopRecordingRequest { world: "wander".to_owned() };
    let closed = asks.call::<v1::StopRecordingResponse>("StopRecording", &request).unwrap();
    let recording = closed.recording.unwrap();
    assert!(recording.bytes > 10_000, "{recording:?}");
    assert!(asks.folder.path().join("wander-1.mcap").is_file());
}

/// `avoid` draws random numbers: with its own seed it would drive another way than in the program.
#[test]
fn another_seed_has_the_hash_that_the_program_has() {
    let mut asks = Asks::new();
    let seed = "seed=10";
    assert_eq!(asks.wander_with(&[seed]).seed, 10);
    asks.order(r#"{"attach":{"world":"wander","robots":["robot"],"brain":"avoid"}}"#);
    let status = asks.run_to_the_end();
    let text = include_str!("../../../catalogue/scenarios/wander.toml");
    let changes = ["end.after_s=60.0", seed].map(|change| Override::parse(change).unwrap());
    let scenario = baudbot_scenario::parse_with(text, &changes).unwrap();
    let brains = assign(&["avoid".to_owned()], &scenario.robots).unwrap().brains;
    let world = in_process::run(scenario, &brains, |_| {}).unwrap();
    assert_eq!(status.state_hash, world.hash());
}

#[test]
fn orders_tell_what_there_is_and_what_is_wrong() {
    let mut asks = Asks::new();
    let catalogue = asks.order(r#"{"catalogue":{}}"#);
    for name in [r#""name":"wander""#, r#""name":"avoid""#, r#""name":"khepera""#] {
        assert!(catalogue.contains(name), "{name}");
    }
    assert!(asks.order(r#"{"scenario":"wander"}"#).contains("9600"));
    assert_eq!(
        asks.order(r#"{"scenario":"../secret"}"#),
        r#"{"error":"there is no scenario `../secret`","id":7}"#
    );
    assert!(asks.order(r#"{"brain":"sweeper"}"#).contains("[motor."));
    assert_eq!(asks.order(r#"{"brain":"avoid"}"#), r#"{"id":7,"result":null}"#);
    let nowhere = asks.order(r#"{"attach":{"world":"nowhere","robots":["robot"],"brain":"avoid"}}"#);
    assert!(nowhere.contains("there is no world `nowhere`"), "{nowhere}");
    assert!(asks.order(r#"{"fly":{}}"#).contains("unknown variant"));
}

#[test]
fn a_brain_that_is_not_there_lets_its_robot_go() {
    let mut asks = Asks::new();
    asks.wander();
    let attach = |brain| format!(r#"{{"attach":{{"world":"wander","robots":["robot"],"brain":"{brain}"}}}}"#);
    let wrong = asks.order(&attach("avoidd"));
    assert!(wrong.contains("no brain `avoidd`"), "{wrong}");
    let right = asks.order(&attach("avoid"));
    assert!(right.contains("result"), "{right}");
    let twice = asks.order(&attach("avoid"));
    assert!(twice.contains("error"), "{twice}");
}

//! The events that are logged to stderr.

use std::time::Duration;

use baudbot_client::{Channel, connect};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use serde_json::Value;

use crate::cli::processes::serve;
use crate::cli::{Running, command, said};

/// A hostile name, which tries to forge a field. A server takes no name that could make a line of its own, or colour
/// the terminal.
const HOSTILE: &str = "a\",\"forged\":1,\"b\":\"\\n";

/// Lets a brain of this name come and go, and ends the server; what it has logged.
fn come_and_go(server: Running, address: &str, brain: &str) -> String {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let client = connect(address).await.unwrap().brain(brain);
        let mut robot = client.attach("wander", "robot").await.unwrap();
        // The first may be of the tick at which it was attached.
        robot.turn().await.unwrap();
        robot.turn().await.unwrap();
        let mut operator = ControlServiceClient::new(client.channel());
        drop((robot, client));
        // The end of its stream and a signal come on different ways.
        until_detached(&mut operator).await;
    });
    // The connection is dropped with its runtime.
    drop(runtime);
    server.signal("-TERM");
    let (code, _, err) = server.end();
    assert_eq!(code, 0, "{err}");
    err
}

async fn until_detached(operator: &mut ControlServiceClient<Channel>) {
    let world = || v1::GetWorldRequest { world: "wander".to_owned() };
    while operator.get_world(world()).await.unwrap().into_inner().status.unwrap().robots[0].attached {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
}

#[test]
fn json_logs_have_simulated_time_and_take_no_line_from_a_brain() {
    let (server, address, _) = serve("json-logs.sock", &["wander", "--log", "info", "--log-format", "json"]);
    let err = come_and_go(server, &address, HOSTILE);
    let lines = err.lines().filter(|line| *line != "stopping");
    let events: Vec<Value> = lines.map(|line| serde_json::from_str(line).expect(line)).collect();
    let said: Vec<_> = events.iter().map(|event| event["message"].as_str().unwrap()).collect();
    let expected = ["world made", "brain attached", "brain detached", "world over, since its server stops"];
    assert_eq!(said, expected);
    for event in &events {
        assert!(
            event["forged"].is_null() && event["level"] == "INFO" && event["world"] == "wander",
            "{event}"
        );
        let (tick, time_s) = (event["tick"].as_f64().unwrap(), event["time_s"].as_f64().unwrap());
        assert!((time_s - tick * 0.01).abs() < 1e-9, "{event}");
    }
    assert!(events[3]["tick"].as_u64().unwrap() > events[1]["tick"].as_u64().unwrap());
    assert_eq!(events[1]["brain"], HOSTILE);
    assert_eq!((&events[2]["robots"], &events[2]["why"]), (&"robot".into(), &"its stream ended".into()));
}

/// A program that is killed has no output at all.
#[test]
fn of_a_brain_that_is_killed_the_log_has_not_the_words_of_the_transport() {
    let (server, tcp, unix) = serve("killed-logs.sock", &["wander", "--log", "info", "--log-format", "json"]);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    for address in [&tcp, &unix] {
        let mut brain = Running::start(&["brain", "avoid", "--connect", address]);
        brain.first_complaint();
        brain.signal("-KILL");
        drop(brain);
        runtime.block_on(async {
            let client = connect(&unix).await.unwrap();
            until_detached(&mut ControlServiceClient::new(client.channel())).await;
        });
    }
    drop(runtime);
    server.signal("-TERM");
    let (_, _, err) = server.end();
    let events = err.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let gone: Vec<_> = events.filter(|event| event["message"] == "brain detached").collect();
    assert!(gone.len() == 2 && gone.iter().all(|event| event["why"] == "its stream ended"), "{err}");
}

#[test]
fn text_logs_take_no_line_from_a_brain() {
    let (server, address, _) = serve("text-logs.sock", &["wander", "--log", "warn,baudbot_server=info"]);
    let err = come_and_go(server, &address, HOSTILE);
    assert!(!err.contains('\u{1b}'), "{err}");
    let lines: Vec<_> = err.lines().filter(|line| *line != "stopping").collect();
    assert_eq!(lines.len(), 4, "{err}");
    assert!(
        lines.iter().all(|line| line.contains(" world=\"wander\" ") && line.contains(" time_s=")),
        "{err}"
    );
    assert!(lines[1].contains(r#"brain="a\",\"forged\":1,"#), "{err}");
}

#[test]
fn an_environment_asks_for_logs_and_is_refused_what_is_no_level() {
    let logged = |level: &str, args: &[&str]| {
        let run = command(&[&["run", "--seconds", "0.1", "--quiet"], args].concat())
            .env("BAUDBOT_LOG", level)
            .output();
        said(run.unwrap())
    };
    let (code, _, err) = logged("info", &[]);
    assert!(code == 0 && err.contains("run ended") && err.contains("time_s=0.1"), "{err}");
    assert_eq!(logged("info", &["--log", "off"]), (0, String::new(), String::new()));
    let (code, _, err) = logged("loud", &[]);
    assert!(code == 2 && err.contains("must be off, error, warn"), "{err}");
}

//! The audit log of a server, and its entries in recordings.

use std::path::Path;
use std::time::SystemTime;

use baudbot_access::{NewGrant, Token, TokenFile};
use baudbot_client::{Client, Credentials, connect_with};
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_recording::RecordedRun;
use baudbot_server::{AuditLog, Server, WorldConfig};
use baudbot_tests::system::lockstep;
use baudbot_tests::{WANDER, scenario};
use serde_json::Value;

/// The lines of a log.
fn lines(file: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(file).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The content of a line, without its instant and its duration.
fn brief(line: &Value) -> String {
    let text = |field: &str| line[field].as_str().unwrap_or("-").to_owned();
    let about =
        line["about"].as_array().map(|names| names.iter().filter_map(Value::as_str).collect::<Vec<_>>());
    let call = text("call");
    let call = call.rsplit('/').next().unwrap();
    format!(
        "{} {} {call} {} {}",
        text("event"),
        text("who"),
        about.unwrap_or_default().join(","),
        text("code")
    )
}

struct Class {
    server: Server,
    teacher: Token,
    alice: Token,
}

impl Class {
    async fn begin(folder: &Path) -> Self {
        let tokens = TokenFile::at(folder.join("tokens.toml"));
        let add = |name: &str, right: &str| {
            let rights = vec![right.parse().unwrap()];
            let new = NewGrant { name: name.parse().unwrap(), rights, expires_at: None };
            tokens.add(new, SystemTime::now()).unwrap()
        };
        let (teacher, alice) = (add("teacher", "operate"), add("alice", "drive w/robot"));
        let world = WorldConfig::new("w", scenario(WANDER, &[])).pace(lockstep()).paused(true);
        let audit = AuditLog::open(&folder.join("audit.jsonl")).unwrap();
        let builder =
            Server::builder().world(world.record(folder.join("run.mcap"), 0.0)).tokens(tokens).audit(audit);
        let server = builder.listen("127.0.0.1:0".parse().unwrap()).serve().await.unwrap();
        Self { server, teacher, alice }
    }

    async fn client(&self, token: &Token) -> Client {
        let credentials = Credentials::default().token(token.reveal().parse().unwrap());
        connect_with(&self.server.addresses()[0].to_string(), &credentials).await.unwrap()
    }
}

#[tokio::test]
async fn who_did_what_is_in_the_log_and_in_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let class = Class::begin(folder.path()).await;
    let mut teacher = ControlServiceClient::new(class.client(&class.teacher).await.channel());
    let alice = class.client(&class.alice).await.brain("mine");
    let mut control = ControlServiceClient::new(alice.channel());
    control.list_worlds(v1::ListWorldsRequest {}).await.unwrap_err();
    control.delete_world(v1::DeleteWorldRequest { world: "w".to_owned() }).await.unwrap_err();
    alice.attach("w", "other").await.map(|_| ()).unwrap_err();
    let mut robot = alice.attach("w", "robot").await.unwrap();
    teacher.list_worlds(v1::ListWorldsRequest {}).await.unwrap();
    teacher.start_world(v1::StartWorldRequest { world: "w".to_owned() }).await.unwrap();
    robot.turn().await.unwrap();
    drop(robot);
    teacher.pause_world(v1::PauseWorldRequest { world: "w".to_owned() }).await.unwrap();
    teacher.delete_world(v1::DeleteWorldRequest { world: "nowhere".to_owned() }).await.unwrap_err();
    class.server.shutdown().await;
    let lines = lines(&folder.path().join("audit.jsonl"));
    let mut told: Vec<_> = lines.iter().map(brief).collect();
    // The instant at which the server notices the end of the brain is a matter of chance.
    told.sort();
    let expected = [
        "begin alice Attach w/other -",
        "begin alice Attach w/robot -",
        "end alice Attach w/other PERMISSION_DENIED",
        "end alice Attach w/robot,w CANCELLED",
        "end teacher DeleteWorld nowhere NOT_FOUND",
        "end teacher PauseWorld w OK",
        "end teacher StartWorld w OK",
        "refused alice DeleteWorld  PERMISSION_DENIED",
        "refused alice ListWorlds  PERMISSION_DENIED",
        "start - -  -",
        "stop - -  -",
    ];
    assert_eq!(told, expected, "{lines:#?}");
    let recorded = RecordedRun::open(&folder.path().join("run.mcap")).unwrap();
    let events: Vec<_> = recorded.events().iter().map(|event| event.text.as_str()).collect();
    let orders: Vec<_> = events.iter().filter(|text| text.starts_with("teacher ")).copied().collect();
    assert_eq!(orders, ["teacher starts the world", "teacher pauses the world"]);
    assert!(events.contains(&"`mine` drives `robot` (token alice)"), "{events:?}");
}

/// Refused callers without a token cannot fill the disk.
#[tokio::test]
async fn a_flood_of_refusals_has_few_lines() {
    let folder = tempfile::tempdir().unwrap();
    let class = Class::begin(folder.path()).await;
    let wrong = Token::random().unwrap();
    let mut control = ControlServiceClient::new(class.client(&wrong).await.channel());
    let begun = std::time::Instant::now();
    for _ in 0..500 {
        control.list_worlds(v1::ListWorldsRequest {}).await.unwrap_err();
    }
    let seconds = begun.elapsed().as_secs() + 2;
    // The next line counts the lines that were left out.
    let mut teacher = ControlServiceClient::new(class.client(&class.teacher).await.channel());
    teacher.pause_world(v1::PauseWorldRequest { world: "w".to_owned() }).await.unwrap();
    class.server.shutdown().await;
    let lines = lines(&folder.path().join("audit.jsonl"));
    let refused = lines.iter().filter(|line| line["event"] == "refused").count() as u64;
    let lost: u64 = lines.iter().filter_map(|line| line["lines"].as_u64()).sum();
    assert_eq!(refused + lost, 500);
    assert!(refused <= 20 * seconds, "{refused} lines in {seconds} s");
}

#[test]
fn only_its_owner_reads_the_log() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("audit.jsonl");
    drop(AuditLog::open(&file).unwrap());
    assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    assert!(AuditLog::open(folder.path()).is_err(), "a folder is no file");
}

#[test]
fn a_pipe_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("audit");
    assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
    let error = AuditLog::open(&path).err().unwrap().to_string();
    assert!(error.starts_with("is a pipe"), "{error}");
}

//! A brain on the bare contract that is right but for one fault, for the tests of `baudbot conform`: `wrong_brain FAULT`.

use std::env;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use baudbot_proto::v1::attach_request::Request;
use baudbot_proto::v1::attach_response::Response;
use baudbot_proto::v1::brain_link_service_client::BrainLinkServiceClient;
use baudbot_proto::v1::robot_step::Output;
use baudbot_proto::v1::{self, AttachRequest};
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::transport::{Channel, Endpoint};
use tonic::{Code, Status};

/// The time after which a command may be lost.
const OVERDUE_NS: u64 = 100_000_000;

struct WrongBrain {
    fault: String,
    to_server: mpsc::Sender<AttachRequest>,
    sheets: Vec<v1::RobotDescription>,
    /// The times at which robots get a command without news.
    due_ns: Vec<u64>,
    commands: u64,
    /// The Turn that was answered last, and its tick.
    last: (u64, u64),
    /// The Turn that was answered last before the world began again.
    old: Option<u64>,
}

impl WrongBrain {
    fn has(&self, fault: &str) -> bool {
        self.fault == fault
    }

    async fn say(&self, request: Request) {
        let _ = self.to_server.send(AttachRequest { request: Some(request) }).await;
    }

    async fn answer(&mut self, turn: v1::Turn) {
        if self.has("answers-an-old-world") && turn.tick < self.last.1 && self.old.is_none() {
            self.old = Some(self.last.0);
        }
        self.last = (turn.turn, turn.tick);
        if self.has("floods") {
            for _ in 0..10 {
                self.say(Request::Step(v1::Step::default())).await;
            }
        }
        if self.has("blocks-on-a-missing-reading") && turn.robots.iter().any(|part| self.lacks_some(part)) {
            return;
        }
        let robots = turn.robots.iter().map(|part| self.part(part)).collect();
        let step = v1::Step { turn: self.old.unwrap_or(turn.turn), robots };
        self.say(Request::Step(step.clone())).await;
        if self.has("answers-twice") {
            self.say(Request::Step(step)).await;
        }
    }

    fn lacks_some(&self, part: &v1::RobotTurn) -> bool {
        let sensors = self.sheets.get(part.robot as usize).map_or(0, |sheet| sheet.sensors.len());
        !part.readings.is_empty() && part.readings.len() < sensors
    }

    fn part(&mut self, turn: &v1::RobotTurn) -> v1::RobotStep {
        let robot = turn.robot;
        if self.has("dies-at-a-split-byte") {
            // Frames end with a 0.
            if turn.raw.last().is_some_and(|byte| *byte != 0) {
                eprintln!("the last frame has no end");
                std::process::exit(3);
            }
            return v1::RobotStep { robot, output: Some(Output::Raw(vec![0])), ..Default::default() };
        }
        let (ignores, due_ns) = (self.has("ignores-readable"), &mut self.due_ns[robot as usize]);
        let is_news = turn.has_message || turn.readings.iter().any(|reading| reading.readable);
        let began_again = *due_ns > turn.at_ns + OVERDUE_NS;
        if !is_news && turn.at_ns < *due_ns && !began_again && !ignores {
            let until_message = Some(v1::UntilMessage { at_latest_ns: Some(*due_ns) });
            return v1::RobotStep { robot, until_message, ..Default::default() };
        }
        *due_ns = turn.at_ns + OVERDUE_NS;
        let until_message = (!ignores).then_some(v1::UntilMessage { at_latest_ns: Some(*due_ns) });
        if self.has("loses-the-second-robot") && robot > 0 {
            return v1::RobotStep { robot, until_message, ..Default::default() };
        }
        self.commands += 1;
        let nearest =
            turn.readings.iter().filter_map(|reading| self.nearness(robot, reading)).fold(0.0, f64::max);
        let left =
            if self.has("sends-nan") && self.commands.is_multiple_of(10) { f64::NAN } else { 0.3 - nearest };
        let command = v1::Command { left_signal: left, right_signal: 0.3, other_signals: Vec::new() };
        v1::RobotStep { robot, until_message, output: Some(Output::Command(command)), ..Default::default() }
    }

    /// The first value of an IR sensor.
    fn nearness(&self, robot: u32, reading: &v1::Reading) -> Option<f64> {
        let sensor = self.sheets.get(robot as usize)?.sensors.get(reading.sensor as usize)?;
        (sensor.kind() == v1::SensorKind::Ir).then_some(*reading.values.first()?)
    }
}

/// One stream. `Ok` is the end of the run.
async fn attach(fault: &str, attached: &mut bool) -> Result<(), Status> {
    let variable = |name: &str| env::var(name).unwrap_or_default();
    let endpoint = Endpoint::try_from(variable("BAUDBOT_CONNECT"))
        .map_err(|error| Status::internal(error.to_string()))?;
    let channel: Channel =
        endpoint.connect().await.map_err(|error| Status::unavailable(error.to_string()))?;
    let (to_server, requests) = mpsc::channel(1024);
    let robots: Vec<_> = variable("BAUDBOT_ROBOT").split(',').map(str::to_owned).collect();
    let is_raw = fault == "dies-at-a-split-byte";
    let mode = if is_raw { v1::PortMode::Raw } else { v1::PortMode::Messages };
    let mut brain = WrongBrain {
        fault: fault.to_owned(),
        to_server,
        sheets: Vec::new(),
        due_ns: vec![0; robots.len()],
        commands: 0,
        last: (0, 0),
        old: None,
    };
    let (world, name) = (variable("BAUDBOT_WORLD"), "wrong_brain".to_owned());
    let hello = v1::Hello {
        world,
        robots,
        mode: mode.into(),
        brain: name,
        thinks_as_scenario: true,
        ..Default::default()
    };
    brain.say(Request::Hello(hello.clone())).await;
    if brain.has("greets-twice") {
        brain.say(Request::Hello(hello)).await;
    } else if brain.has("steps-before-the-welcome") {
        brain.say(Request::Step(v1::Step::default())).await;
    }
    let mut request = tonic::Request::new(ReceiverStream::new(requests));
    if fault != "forgets-the-token" {
        let token = format!("Bearer {}", variable("BAUDBOT_TOKEN")).parse().expect("a token");
        request.metadata_mut().insert("authorization", token);
    }
    let mut server = BrainLinkServiceClient::new(channel).attach(request).await?.into_inner();
    while let Some(response) = server.message().await? {
        match response.response {
            Some(Response::Welcome(welcome)) => {
                brain.sheets = welcome.robots;
                *attached = true;
            }
            Some(Response::Turn(turn)) => brain.answer(turn).await,
            // One that stays is right, too: an operator may reset the world.
            Some(Response::Ended(_)) if fault == "stays" => {}
            Some(Response::Ended(_)) => return Ok(()),
            None => {}
        }
    }
    Err(Status::unavailable("the server closed the stream"))
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> ExitCode {
    let fault = env::args().nth(1).unwrap_or_default();
    let patience_s: u64 =
        env::var("BAUDBOT_RECONNECT_S").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    let mut lost = Instant::now();
    loop {
        let mut attached = false;
        let Err(status) = attach(&fault, &mut attached).await else { return ExitCode::SUCCESS };
        if attached {
            lost = Instant::now();
        }
        let restarts = status.metadata().contains_key(baudbot_proto::REASON);
        let comes_back = match status.code() == Code::Unavailable || restarts {
            true => !(attached && fault == "never-reconnects"),
            false => false,
        };
        if !comes_back || lost.elapsed() > Duration::from_secs(patience_s) {
            eprintln!("wrong_brain: {}", status.message());
            return ExitCode::FAILURE;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

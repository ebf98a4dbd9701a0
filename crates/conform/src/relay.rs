//! One stream of a brain: what it says goes to the world, and what the world says comes to it, changed by the provocation.

use std::time::Duration;

use baudbot_proto::v1::attach_request::Request;
use baudbot_proto::v1::attach_response::Response;
use baudbot_proto::v1::encoding::Kind;
use baudbot_proto::v1::{self, AttachRequest, AttachResponse};
use tokio::sync::mpsc;
use tokio::time::{Instant, interval, sleep, sleep_until, timeout_at};
use tonic::{Status, Streaming};

use crate::provocation::{AFTER, Provocation};
use crate::record::Event;
use crate::scene::WORLD;
use crate::spy::Spy;

/// A stream between a brain and a world.
pub(crate) struct Relay {
    spy: Spy,
    /// The stream's number.
    stream: usize,
    to_brain: mpsc::Sender<Result<AttachResponse, Status>>,
    /// The Turn that the brain has not answered.
    owed: Option<u64>,
    /// The number of Turns that the brain was given.
    turns: usize,
    /// Whether what is provoked has happened.
    has_happened: bool,
    /// The number of sensors in the data sheet of each robot, as the world has it.
    sensors: Vec<u32>,
    /// Responses that come later in a burst.
    held: Vec<AttachResponse>,
    /// Bytes of each robot that come later.
    late_bytes: Vec<Vec<u8>>,
    /// The instant at which there is nothing more to see.
    until: Option<Instant>,
}

/// What becomes of the stream.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Goes {
    On,
    Ends,
}

impl Relay {
    pub(crate) fn new(
        spy: Spy,
        stream: usize,
        to_brain: mpsc::Sender<Result<AttachResponse, Status>>,
    ) -> Self {
        Self {
            spy,
            stream,
            to_brain,
            owed: None,
            turns: 0,
            has_happened: stream > 0,
            sensors: Vec::new(),
            held: Vec::new(),
            late_bytes: Vec::new(),
            until: None,
        }
    }

    /// Relays until one side ends.
    pub(crate) async fn run(self, mut brain: Streaming<AttachRequest>) {
        let Some(hello) = self.hello(&mut brain).await else { return };
        self.before_the_welcome(&mut brain).await;
        match self.spy.attach(hello).await {
            Err(status) => {
                let _ = self.to_brain.send(Err(status)).await;
            }
            Ok((to_world, world)) => self.both_ways(brain, to_world, world).await,
        }
    }

    /// The Hello. What comes before it is noted.
    async fn hello(&self, brain: &mut Streaming<AttachRequest>) -> Option<v1::Hello> {
        loop {
            match brain.message().await.ok()??.request {
                Some(Request::Hello(hello)) => {
                    self.spy.on_stream(self.stream, |stream| stream.hello = Some(hello.clone()));
                    // What it promises is judged here, and so that the stream goes on the server is not told.
                    return Some(v1::Hello { thinks_as_scenario: false, ..hello });
                }
                Some(Request::Step(_) | Request::Annotate(_)) | None => self.note(Event::BeforeHello),
            }
        }
    }

    /// The Welcome waits for a moment, so that what comes before it is seen on any machine.
    async fn before_the_welcome(&self, brain: &mut Streaming<AttachRequest>) {
        let end = Instant::now() + EARLY;
        while let Ok(Ok(Some(request))) = timeout_at(end, brain.message()).await {
            match request.request {
                Some(Request::Hello(_)) => self.note(Event::SecondHello),
                Some(Request::Step(_)) => self.note(Event::BeforeWelcome),
                Some(Request::Annotate(annotate)) => self.note(Event::Annotate(annotate)),
                None => {}
            }
        }
    }

    async fn both_ways(
        mut self,
        mut brain: Streaming<AttachRequest>,
        to_world: mpsc::Sender<AttachRequest>,
        mut world: Streaming<AttachResponse>,
    ) {
        if self.spy.provocation.is_timed() {
            let _ = self.spy.operator().start_world(v1::StartWorldRequest { world: WORLD.to_owned() }).await;
        }
        let mut burst = interval(BURST);
        loop {
            let goes = tokio::select! {
                said = brain.message() => match said {
                    Ok(Some(request)) => self.take_from_brain(request, &to_world).await,
                    Ok(None) | Err(_) => {
                        self.note(Event::Closed);
                        Goes::Ends
                    }
                },
                said = world.message() => match said {
                    Ok(Some(response)) => self.take_from_world(response).await,
                    Ok(None) => Goes::Ends,
                    Err(status) => {
                        let _ = self.to_brain.send(Err(status)).await;
                        Goes::Ends
                    }
                },
                _ = burst.tick(), if !self.held.is_empty() => self.let_go().await,
                () = reached(self.until) => self.is_over().await,
            };
            if goes == Goes::Ends {
                if self.until.is_some() {
                    self.spy.finish();
                }
                return;
            }
        }
    }

    /// The run has been over for a while, and the brain is still there.
    async fn is_over(&mut self) -> Goes {
        self.until = None;
        if self.spy.provocation == Provocation::End && !self.has_happened {
            self.has_happened = true;
            self.note(Event::Reset);
            self.spy.reset().await;
        } else {
            self.spy.finish();
        }
        Goes::On
    }

    fn note(&self, event: Event) {
        self.spy.note(self.stream, event);
    }

    async fn take_from_brain(
        &mut self,
        request: AttachRequest,
        to_world: &mpsc::Sender<AttachRequest>,
    ) -> Goes {
        let request = match request.request {
            Some(Request::Hello(_)) => {
                self.note(Event::SecondHello);
                return Goes::On;
            }
            Some(Request::Step(step)) => match self.step(step) {
                Some(step) => Request::Step(step),
                None => return Goes::On,
            },
            Some(Request::Annotate(annotate)) => {
                self.note(Event::Annotate(annotate.clone()));
                Request::Annotate(annotate)
            }
            None => return Goes::On,
        };
        // A world that is gone has said so.
        let _ = to_world.send(AttachRequest { request: Some(request) }).await;
        Goes::On
    }

    /// Notes a Step. The world gets it if it can be taken as the answer to a Turn, without what would end the stream.
    fn step(&mut self, step: v1::Step) -> Option<v1::Step> {
        self.note(Event::Step(step.clone()));
        let turn = match (self.owed, self.spy.provocation.is_timed()) {
            (_, true) => step.turn,
            // A number of another Turn is judged, and taken for the one that is owed, so that the run goes on.
            (Some(owed), false) if step.turn != 0 => owed,
            (Some(_) | None, false) => return None,
        };
        self.owed = None;
        let robots = self.sensors.len();
        let is_sound = |part: &v1::RobotStep| (part.robot as usize) < robots;
        let mut sound: Vec<_> = step.robots.into_iter().filter(is_sound).collect();
        sound.sort_by_key(|part| part.robot);
        sound.dedup_by_key(|part| part.robot);
        for part in &mut sound {
            if let Some(v1::robot_step::Output::Command(command)) = &mut part.output {
                let signals = [&mut command.left_signal, &mut command.right_signal].into_iter();
                for signal in signals.chain(&mut command.other_signals).filter(|signal| !signal.is_finite()) {
                    *signal = 0.0;
                }
            }
        }
        Some(v1::Step { turn, robots: sound })
    }

    async fn take_from_world(&mut self, response: AttachResponse) -> Goes {
        match response.response {
            Some(Response::Welcome(welcome)) => {
                self.sensors = welcome.robots.iter().map(|robot| robot.sensors.len() as u32).collect();
                self.late_bytes = vec![Vec::new(); welcome.robots.len()];
                let welcome = self.changed_sheet(welcome);
                self.spy.on_stream(self.stream, |stream| stream.welcome = Some(welcome.clone()));
                self.tell(AttachResponse { response: Some(Response::Welcome(welcome)) }).await;
                if self.spy.provocation == Provocation::Unknown {
                    self.tell(AttachResponse { response: None }).await;
                }
                Goes::On
            }
            Some(Response::Turn(turn)) => self.turn(turn).await,
            Some(Response::Ended(ended)) => {
                self.note(Event::Ended);
                self.until = Some(Instant::now() + GRACE);
                self.tell(AttachResponse { response: Some(Response::Ended(ended)) }).await;
                Goes::On
            }
            None => Goes::On,
        }
    }

    async fn turn(&mut self, turn: v1::Turn) -> Goes {
        let mut turn = turn;
        // What happens at the end has its own time.
        let is_due = self.turns >= AFTER && !self.has_happened && self.spy.provocation != Provocation::End;
        if is_due && let Some(goes) = self.happens().await {
            return goes;
        }
        self.turns += 1;
        turn.robots.iter_mut().for_each(|part| self.change(part));
        self.note(Event::Turn(turn.clone()));
        let response = AttachResponse { response: Some(Response::Turn(turn.clone())) };
        self.owed = Some(turn.turn);
        if self.spy.provocation.is_timed() {
            self.held.push(response);
        } else {
            self.tell(response).await;
        }
        // A world that came back, or began again, is seen for a while.
        if self.has_happened && self.turns >= 2 * AFTER && self.spy.provocation.has_two_streams() {
            self.spy.finish();
        }
        Goes::On
    }

    /// Makes the thing happen; `None` if the Turn that was about to come still does.
    async fn happens(&mut self) -> Option<Goes> {
        if let Some(status) = self.spy.provocation.broken_off() {
            let _ = self.to_brain.send(Err(status)).await;
            return Some(Goes::Ends);
        }
        self.has_happened = true;
        let world = WORLD.to_owned();
        let mut operator = self.spy.operator();
        if self.spy.provocation == Provocation::Reset {
            self.note(Event::Reset);
            self.spy.reset().await;
            // The Turn was of before it.
            return Some(Goes::On);
        }
        if self.spy.provocation == Provocation::Deleted {
            let _ = operator.delete_world(v1::DeleteWorldRequest { world }).await;
            return Some(Goes::On);
        }
        if self.spy.provocation == Provocation::Pause {
            let _ = operator.pause_world(v1::PauseWorldRequest { world: world.clone() }).await;
            tokio::spawn(async move {
                sleep(PAUSE).await;
                let _ = operator.start_world(v1::StartWorldRequest { world }).await;
            });
        }
        None
    }

    async fn tell(&self, response: AttachResponse) {
        let _ = self.to_brain.send(Ok(response)).await;
    }

    /// Lets a burst go.
    async fn let_go(&mut self) -> Goes {
        for response in std::mem::take(&mut self.held) {
            self.tell(response).await;
        }
        Goes::On
    }

    /// The data sheets as the brain is to see them.
    fn changed_sheet(&self, mut welcome: v1::Welcome) -> v1::Welcome {
        for robot in &mut welcome.robots {
            if self.spy.provocation == Provocation::Reversed {
                robot.sensors.reverse();
            } else if self.spy.provocation == Provocation::Unknown {
                robot.sensors.push(of_tomorrow());
            }
        }
        welcome
    }

    /// A robot's part of a Turn as the brain is to see it.
    fn change(&mut self, part: &mut v1::RobotTurn) {
        let Some(&sensors) = self.sensors.get(part.robot as usize) else { return };
        let provocation = self.spy.provocation;
        if provocation == Provocation::Reversed {
            part.readings.iter_mut().for_each(|reading| reading.sensor = sensors - 1 - reading.sensor);
            part.ports.iter_mut().for_each(|port| port.sensor = sensors - 1 - port.sensor);
        } else if provocation == Provocation::Unknown && !part.readings.is_empty() {
            let (values, readable) = (vec![1.0, 2.0], part.has_message);
            part.readings.push(v1::Reading { sensor: sensors, values, readable, ..Default::default() });
        } else if provocation == Provocation::NoReading && self.turns <= AFTER {
            part.readings.clear();
            part.has_message = false;
        } else if provocation == Provocation::MissingSensor {
            part.readings.retain(|reading| reading.sensor != 0);
        } else if provocation == Provocation::NoEcho {
            let values = part.readings.iter_mut().flat_map(|reading| &mut reading.values);
            values.for_each(|value| *value = -1.0);
        } else if provocation == Provocation::Split {
            let late = &mut self.late_bytes[part.robot as usize];
            let mut bytes = std::mem::take(late);
            bytes.append(&mut part.raw);
            let cut = bytes.len() - (self.turns % 4).min(bytes.len());
            *late = bytes.split_off(cut);
            part.raw = bytes;
        }
    }
}

/// A sensor of a kind that the contract may have one day, on a cable of its own.
fn of_tomorrow() -> v1::SensorDescription {
    let encoding = Some(v1::Encoding { kind: Some(Kind::Float64(v1::encoding::Float64 {})) });
    v1::SensorDescription {
        sensor: "sensor_of_tomorrow".to_owned(),
        kind: 999,
        components: vec![v1::ComponentDescription {
            count: 2,
            unit: "1".to_owned(),
            encoding,
            ..Default::default()
        }],
        period_ns: 20_000_000,
        port: Some(v1::Port { format: 999, message_bytes: 8, ..Default::default() }),
        ..Default::default()
    }
}

async fn reached(instant: Option<Instant>) {
    match instant {
        Some(instant) => sleep_until(instant).await,
        None => std::future::pending().await,
    }
}

/// The time for which a Welcome waits.
const EARLY: Duration = Duration::from_millis(50);

/// The interval of bursts.
const BURST: Duration = Duration::from_millis(200);

/// The time for which a world is paused.
const PAUSE: Duration = Duration::from_millis(300);

/// The time for which a brain is seen after its run is over.
const GRACE: Duration = Duration::from_millis(500);

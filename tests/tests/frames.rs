//! Every number of a frame is of the frame's own instant: running, stepped, standing, replayed and recorded.
//!
//! The oracle is a world of its own with the recorded bytes in, looked at between two ticks; when readings came, and how old they
//! were, it has from the timeline. Its values are written out field by field, so that a new field of the contract does
//! not compile here before it has one.

use std::collections::BTreeSet;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_recording::{Frames, RecordedRun};
use baudbot_server::{Lockstep, Pace, Server, WorldConfig};
use baudbot_sim::link::LineCounters;
use baudbot_sim::raycast::RayCaster;
use baudbot_sim::surroundings::Zone;
use baudbot_sim::timeline::What;
use baudbot_sim::{Histogram, Input, RobotView, SimTime, ThingView, World};
use baudbot_tests::system::{client, drive, operator, status};
use baudbot_tests::{WANDER, scenario};
use prost::Message;
use prost_types::FileDescriptorSet;
use tonic::Streaming;

/// The parts of a frame for which the oracle has no values here.
const ELSEWHERE: [(&str, &str); 4] = [
    ("Annotation", "what brains say is no number of the world's"),
    ("Belief", "as Annotation"),
    ("Collision", "events are told once, to each observer: tests/tests/services.rs"),
    ("PinEvent", "tests/tests/pins.rs"),
];
/// The parts for which it has values.
const HERE: [&str; 14] = [
    "ActuatorTruth",
    "BatteryStatus",
    "CycleStatus",
    "Durations",
    "LineStatus",
    "RayFan",
    "RobotDetail",
    "RobotTruth",
    "Score",
    "SensorDetail",
    "ThingTruth",
    "TimelineEvent",
    "WatchResponse",
    "ZoneStatus",
];

/// The parts that `wander` lacks: a frame with a number of each kind.
const MORE: &str = r#"
    [robots.battery]
    nominal_v = 4.8
    capacity_mah = 2000
    idle_w = 1.0

    [robots.actuators.lamp]
    kind = "lamp"
    intensity_cd = 1.0

    [[arena.zones]]
    name = "here"
    x_m = -0.2
    y_m = 0.0
    radius_m = 0.1
    goal = true

    [[arena.zones]]
    name = "there"
    x_m = 1.2
    y_m = -1.2
    radius_m = 0.1

    [[arena.movers]]
    name = "door"
    outline_m = [[0.0, 0.0], [0.4, 0.0], [0.4, 0.05], [0.0, 0.05]]
    x_m = 1.2
    y_m = 1.2
    swing = { to_rad = 3.0, rate_rad_s = 2.0 }

    [metrics]
    cell_m = 0.1
    sensed_by = "ir_front"
"#;

#[test]
fn all_that_a_frame_is_made_of_has_an_oracle() {
    let files = FileDescriptorSet::decode(baudbot_proto::DESCRIPTORS).unwrap();
    let mut found = BTreeSet::new();
    let mut open = vec![".baudbot.v1.WatchResponse".to_owned()];
    while let Some(name) = open.pop() {
        let messages = files.file.iter().flat_map(|file| &file.message_type);
        let short = name.trim_start_matches(".baudbot.v1.").to_owned();
        let Some(message) = messages.into_iter().find(|message| message.name() == short) else { continue };
        // A part that is left out takes its own parts with it.
        if found.insert(short.clone()) && HERE.contains(&&*short) {
            open.extend(message.field.iter().filter_map(|field| field.type_name.clone()));
        }
    }
    let known: BTreeSet<_> = HERE.into_iter().chain(ELSEWHERE.map(|(name, _)| name)).collect();
    // Beliefs are in annotations only.
    found.insert("Belief".to_owned());
    assert_eq!(found.iter().map(String::as_str).collect::<BTreeSet<_>>(), known);
}

/// A reading of a sensor: when it was sampled, and when it was at the laptop.
type Arrival = (u64, u64);

/// A world with the recorded bytes in.
struct Oracle {
    run: Arc<RecordedRun>,
    world: World,
    /// The begin and the end of the events of each robot's timeline, and how many there were as each tick began.
    events: Vec<(u64, u64)>,
    events_before: Vec<usize>,
    acquired: Vec<Option<u64>>,
    framed: Vec<Vec<(usize, u64)>>,
    arrivals: Vec<Vec<Arrival>>,
    /// The instants at which the brain has stepped.
    steps: Vec<u64>,
}

impl Oracle {
    fn new(run: Arc<RecordedRun>) -> Self {
        let world = World::new(Arc::clone(run.scenario()));
        let sensors = run.scenario().robots[0].sensors.len();
        let (acquired, arrivals) = (vec![None; sensors], vec![Vec::new(); sensors]);
        Self {
            run,
            world,
            events: Vec::new(),
            events_before: vec![0],
            acquired,
            framed: Vec::new(),
            arrivals,
            steps: Vec::new(),
        }
    }

    fn tick(&mut self) {
        let turns = self.world.begin().to_vec();
        self.steps.extend(turns.iter().map(|turn| turn.at.as_ns()));
        let recorded = self.run.inputs_at(self.world.tick()).unwrap();
        let now = self.world.time().as_ns();
        let inputs = recorded.iter().flat_map(|recorded| &recorded.inputs);
        let inputs = inputs.map(|input| Input {
            robot: input.robot as usize,
            at: SimTime::from_ns(now.saturating_add_signed(input.after_ns)),
            bytes: &input.data,
        });
        self.world.finish(&inputs.collect::<Vec<_>>());
        self.read_timeline();
        self.events_before.push(self.events.len());
    }

    /// Finds the readings that have come, by the entries on the microcontroller and on the wire.
    fn read_timeline(&mut self) {
        let robot = self.world.robot(0);
        let (missed, events) = robot.timeline().since(self.events.len() as u64);
        assert_eq!(missed, 0);
        for event in events {
            self.events.push((event.start.as_ns(), event.end.as_ns()));
            match event.what {
                What::Acquire { sensor } => self.acquired[usize::from(sensor)] = Some(event.start.as_ns()),
                What::Frame { .. } => {
                    let acquired = self.acquired.iter_mut().enumerate();
                    self.framed.push(acquired.filter_map(|(i, at)| Some((i, at.take()?))).collect());
                }
                What::Up { .. } => {
                    for (i, sampled) in self.framed.remove(0) {
                        self.arrivals[i].push((sampled, event.end.as_ns()));
                    }
                }
                _ => {}
            }
        }
    }

    /// The greatest and the least age of a sensor's reading since an instant, at both ends and as readings came.
    fn ages(&self, sensor: usize, since: u64, now: u64) -> Option<(u64, u64)> {
        let at = |instant: u64, including: bool| {
            let came = |&&(_, at): &&Arrival| at < instant || including && at == instant;
            self.arrivals[sensor].iter().rev().find(came).map(|(sampled, _)| instant - sampled)
        };
        let came = self.arrivals[sensor].iter().filter(|(_, at)| (since..now).contains(at));
        let ages = came.flat_map(|&(_, instant)| [at(instant, false), at(instant, true)]);
        let ages: Vec<_> = ages.chain([at(since, false), at(now, false)]).flatten().collect();
        Some((*ages.iter().min()?, *ages.iter().max()?))
    }

    /// The frame of an observer whose last one was of this tick.
    fn frame(&self, last: u64) -> v1::WatchResponse {
        let (world, robot) = (&self.world, self.world.robot(0));
        let step_ns = world.scenario().step_ns;
        let scenario = world.scenario();
        let zones = scenario.surroundings.zones.iter().zip(world.score().visited());
        let zone = |(zone, visited): (&Zone, &bool)| v1::ZoneStatus {
            zone: zone.name.clone(),
            goal: zone.goal,
            visited: *visited,
        };
        v1::WatchResponse {
            tick: world.tick(),
            time_ns: world.tick() * step_ns,
            robots: vec![truth(world, &robot)],
            collisions: Vec::new(),
            missed_frames: 0,
            ending: world.ending().map(ToString::to_string).unwrap_or_default(),
            things: world.things().map(|thing| self::thing(&thing)).collect(),
            score: Some(v1::Score {
                covered: Some(world.score().covered(&scenario.rules).unwrap()),
                sensed: Some(world.score().sensed(&scenario.rules).unwrap()),
                zones: zones.map(zone).collect(),
                goals: 1,
                goals_reached: world.score().visited()[0].into(),
            }),
            details: vec![self.detail(&robot, last * step_ns)],
            annotations: Vec::new(),
        }
    }

    fn detail(&self, robot: &RobotView<'_>, since: u64) -> v1::RobotDetail {
        let [up, down] = robot.under_way();
        let cycles = robot.cycles();
        v1::RobotDetail {
            robot: 0,
            sensors: (0..self.arrivals.len()).map(|i| self.sensor(robot, i, since)).collect(),
            uplink: Some(line(robot.uplink())),
            downlink: Some(line(robot.downlink())),
            uplink_waiting_bytes: up,
            downlink_waiting_bytes: down,
            cycles: Some(v1::CycleStatus {
                deadline_ns: robot.spec().deadline.within_ns,
                kept: cycles.kept,
                late: cycles.late,
                unanswered: cycles.unanswered,
                durations: durations(&cycles.durations),
                unstated_writes: cycles.exceptions.writes,
                disturbed: cycles.exceptions.cycles,
            }),
            events: Vec::new(),
            missed_events: 0,
            attached: true,
            brain: "brain".into(),
            cable_pulled: false,
            baud: Some(9600),
            pin_events: Vec::new(),
            missed_pin_events: 0,
            at_ns: None,
        }
    }

    fn sensor(&self, robot: &RobotView<'_>, i: usize, since: u64) -> v1::SensorDetail {
        let now = self.world.time().as_ns();
        let last = self.arrivals[i].iter().rev().find(|(_, at)| *at < now).copied();
        let step = self.steps.iter().rev().find(|&&step| step < now).copied();
        let view = robot.sensors().nth(i).unwrap();
        let ages = self.ages(i, since, now);
        v1::SensorDetail {
            values: robot.readings()[i].values.to_vec(),
            sampled_at_ns: last.map(|(sampled, _)| sampled),
            readable: last.is_some_and(|(_, at)| step.is_none_or(|step| at > step)),
            samples: view.samples,
            missed: view.missed,
            readable_steps: view.freshness.readable,
            rays: Some(self.rays(robot, i)),
            port: None,
            least_age_ns: ages.map(|(least, _)| least),
            most_age_ns: ages.map(|(_, most)| most),
        }
    }

    fn rays(&self, robot: &RobotView<'_>, i: usize) -> v1::RayFan {
        let (caster, sensor) = (RayCaster::new(&self.world), &robot.spec().sensors[i]);
        let pose = caster.place(0, sensor.device.mount().unwrap());
        let range_m = sensor.device.range_m().unwrap();
        v1::RayFan {
            x_m: pose.position.x,
            y_m: pose.position.y,
            heading_rad: pose.heading,
            opening_rad: 0.5,
            lengths_m: caster
                .sees(0, sensor)
                .iter()
                .map(|ray| ray.distance_m.unwrap_or(range_m) as f32)
                .collect(),
        }
    }
}

fn truth(world: &World, robot: &RobotView<'_>) -> v1::RobotTruth {
    let (motion, signals) = (robot.motion(), robot.signals());
    v1::RobotTruth {
        x_m: motion.pose.position.x,
        y_m: motion.pose.position.y,
        heading_rad: motion.pose.heading,
        speed_m_s: motion.speed_m_s,
        turn_rate_rad_s: motion.turn_rate_rad_s,
        left_signal: signals.left,
        right_signal: signals.right,
        collided: robot.collided(),
        samples: robot.sensors().map(|sensor| sensor.sample.first().copied().unwrap_or(f64::NAN)).collect(),
        battery: robot.battery().map(|(battery, state)| v1::BatteryStatus {
            charge: state.share(battery),
            voltage_v: state.terminal_v(battery),
            current_a: state.current_a,
            used_j: state.used_j,
            charged_j: state.charged_j,
        }),
        actuators: robot
            .actuators()
            .iter()
            .map(|actuator| v1::ActuatorTruth { signal: actuator.signal, angle_rad: actuator.angle_rad })
            .collect(),
        in_zone_ns: world.score().in_zone_ns(0).to_vec(),
    }
}

fn thing(thing: &ThingView<'_>) -> v1::ThingTruth {
    v1::ThingTruth {
        thing: thing.name.to_owned(),
        x_m: thing.pose.position.x,
        y_m: thing.pose.position.y,
        heading_rad: thing.pose.heading,
        blocked_ns: thing.blocked_ns,
    }
}

fn line(line: &LineCounters) -> v1::LineStatus {
    v1::LineStatus {
        bytes: line.bytes,
        corrupted_bytes: line.corrupted_bytes,
        overrun_bytes: line.overrun_bytes,
        refused_bytes: line.refused_bytes,
        messages: line.messages,
        bad_frames: line.bad_frames,
        bad_messages: line.bad_messages,
        lost_bytes: line.lost_bytes,
    }
}

fn durations(histogram: &Histogram) -> Option<v1::Durations> {
    Some(v1::Durations {
        count: histogram.count(),
        mean_ns: histogram.mean_ns()?,
        min_ns: histogram.min_ns()?,
        p50_ns: histogram.quantile_ns(0.5)?,
        p95_ns: histogram.quantile_ns(0.95)?,
        p99_ns: histogram.quantile_ns(0.99)?,
        max_ns: histogram.max_ns()?,
    })
}

/// A frame of an observer, with the tick behind which it came, `None` if it was the first.
type Seen = (&'static str, Option<u64>, v1::WatchResponse);

/// An observer who stays.
struct Observer {
    name: &'static str,
    stream: Streaming<v1::WatchResponse>,
    last: Option<u64>,
}

impl Observer {
    async fn come(server: &Server, name: &'static str, every_ticks: u64) -> Self {
        let mut observe = ObserveServiceClient::new(server.channel().await.unwrap());
        let (world, details) = ("w".to_owned(), vec!["robot".to_owned()]);
        let request = v1::WatchRequest { world, every_ticks, details, ..Default::default() };
        Self { name, stream: observe.watch(request).await.unwrap().into_inner(), last: None }
    }

    async fn see(&mut self) -> Seen {
        let frame = self.stream.message().await.unwrap().unwrap();
        (self.name, self.last.replace(frame.tick), frame)
    }
}

const TICKS: u64 = 150;

/// The frames of a run, which is recorded.
async fn seen_live(folder: &std::path::Path) -> Vec<Seen> {
    let world = scenario(&format!("{WANDER}{MORE}"), &["end.after_s=1.5"]);
    let world = WorldConfig::new("w", world).pace(Pace::Stepped(Lockstep::default()));
    let server = Server::builder().world(world).recordings(folder.to_owned()).in_process().await.unwrap();
    let mut operator = operator(&server).await;
    let (world, recording) = ("w".to_owned(), "run".to_owned());
    operator.start_recording(v1::StartRecordingRequest { world, recording, look_hz: 50.0 }).await.unwrap();
    let brains = client(&server).await;
    let brain = tokio::spawn(async move { drive(&brains, "robot", "avoid", 1).await });
    while !status(&server).await.robots[0].attached {
        tokio::task::yield_now().await;
    }
    let mut each = Observer::come(&server, "running, each tick", 1).await;
    let mut fourth = Observer::come(&server, "running, each fourth tick", 4).await;
    let mut seen = vec![each.see().await, fourth.see().await];
    for tick in 0..TICKS {
        operator.step_world(v1::StepWorldRequest { world: "w".into(), ticks: 1 }).await.unwrap();
        seen.push(each.see().await);
        if tick % 4 == 0 {
            seen.push(fourth.see().await);
        }
        if tick % 7 == 0 {
            seen.push(Observer::come(&server, "standing", 1).await.see().await);
        }
    }
    seen.extend([each.see().await, fourth.see().await]);
    brain.await.unwrap();
    operator.stop_recording(v1::StopRecordingRequest { world: "w".into() }).await.unwrap();
    server.shutdown().await;
    seen
}

/// The frames of its replay, forwards and backwards.
async fn seen_again(folder: &std::path::Path) -> Vec<Seen> {
    let server = Server::builder().recordings(folder.to_owned()).in_process().await.unwrap();
    let mut operator = operator(&server).await;
    let open = v1::OpenRecordingRequest { recording: "run".into(), world: "w".into() };
    operator.open_recording(open).await.unwrap();
    let mut stays = Observer::come(&server, "replay", 1).await;
    let mut seen = vec![stays.see().await];
    for tick in [40, 41, 42, 43, 47, 101, 102] {
        operator.seek_replay(v1::SeekReplayRequest { world: "w".into(), tick }).await.unwrap();
        seen.push(stays.see().await);
    }
    for tick in [149, 2, 3, 52, 53, 54, 55] {
        operator.seek_replay(v1::SeekReplayRequest { world: "w".into(), tick }).await.unwrap();
        seen.push(Observer::come(&server, "replay, from here on", 1).await.see().await);
    }
    server.shutdown().await;
    seen
}

#[tokio::test]
async fn every_number_of_a_frame_is_of_its_own_instant() {
    let folder = tempfile::tempdir().unwrap();
    let mut seen = seen_live(folder.path()).await;
    seen.extend(seen_again(folder.path()).await);
    let file = folder.path().join("run.mcap");
    let mut last = None;
    for frame in Frames::open(&file).unwrap() {
        let frame = frame.unwrap();
        seen.push(("recorded", last.replace(frame.tick), frame));
    }
    assert!(seen.len() > 280, "{}", seen.len());
    let mut oracle = Oracle::new(Arc::new(RecordedRun::open(&file).unwrap()));
    let mut ages = BTreeSet::new();
    for tick in 0..=TICKS {
        for (who, last, frame) in seen.iter().filter(|(_, _, frame)| frame.tick == tick) {
            let mut right = oracle.frame(last.unwrap_or(tick));
            if who.starts_with("replay") {
                (right.details[0].attached, right.details[0].brain) = (false, String::new());
            }
            assert_eq!(lasting(frame), lasting(&right), "{who}, tick {tick}, after {last:?}");
            if let Some(last) = last {
                let told = frame.details[0].events.iter().map(|event| (event.start_ns, event.end_ns));
                let right = &oracle.events[oracle.events_before[*last as usize]..];
                assert_eq!(told.collect::<Vec<_>>(), right, "{who}, tick {tick}, after {last}");
            }
            let sensor = &frame.details[0].sensors[0];
            ages.extend(
                [sensor.least_age_ns, sensor.most_age_ns].into_iter().flatten().filter(|_| tick > 20),
            );
        }
        oracle.tick();
    }
    // The last byte is there 20.4 ms after the sensors were read, which is every 20 ms.
    let (least, most) = (ages.first().unwrap() / 100_000, ages.last().unwrap() / 100_000);
    assert_eq!((least, most), (204, 404), "in tenths of a millisecond");
}

/// A frame without its one-time parts. No event has begun later than the frame.
fn lasting(frame: &v1::WatchResponse) -> String {
    let mut frame = frame.clone();
    for detail in &mut frame.details {
        let later: Vec<_> = detail.events.iter().filter(|event| event.start_ns > frame.time_ns).collect();
        assert!(later.is_empty(), "tick {}: {later:?}", frame.tick);
        detail.events.clear();
    }
    frame.collisions.clear();
    format!("{frame:#?}")
}

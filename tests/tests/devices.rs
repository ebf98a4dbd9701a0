//! Turrets, sensors with a cable of their own, batteries and brains on board, over real gRPC.

use baudbot_client::{Action, Brain, Client, Error, RawCommands, RawReadings, Signals, Turn, run};
use baudbot_proto::v1;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_server::{Lockstep, Pace, Server};
use baudbot_tests::system::{client, lockstep, operator, serve, status};
use baudbot_tests::{InProcess, scenario};
use baudbot_wire::scip;
use tonic::Code;

/// A robot that looks at a box 0.9 m ahead, between a door that cannot swing and a ball.
const SCOUT: &str = r#"
    step_ms = 10.0
    substeps = 10
    end.after_s = 1.0
    metrics.cell_m = 0.1

    [[arena.polygons]]
    name = "box"
    points_m = [[1.0, -1.0], [1.5, -1.0], [1.5, 1.0], [1.0, 1.0]]
    height_m = 0.5
    color = [200, 0, 0]

    [[arena.polygons]]
    name = "line"
    points_m = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]]
    solid = false
    closed = false

    [[arena.zones]]
    name = "home"
    x_m = 0.0
    y_m = 0.0
    radius_m = 0.3
    goal = true

    [[arena.lights]]
    name = "lamp"
    x_m = 2.0
    y_m = 2.0
    intensity_cd = 10.0

    [[arena.fields]]
    name = "scent"
    sources = [{ x_m = 1.0, y_m = 2.0, strength = 3.0, width_m = 0.5 }]

    [[arena.movers]]
    name = "door"
    outline_m = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.05], [0.0, 0.05]]
    x_m = -0.5
    y_m = -0.02
    heading_rad = 3.0
    swing = { to_rad = 6.28, rate_rad_s = 10.0 }

    [[arena.movables]]
    name = "ball"
    x_m = 0.0
    y_m = 0.5
    radius_m = 0.1
    mass_kg = 0.5
    friction = 0.1

    [[robots]]
    name = "scout"
    body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
    battery = { nominal_v = 4.8, capacity_mah = 2000, idle_w = 1.0 }
    link = { kind = "uart", baud = 38400 }

    [robots.actuators.lamp]
    kind = "lamp"
    intensity_cd = 1.0

    [robots.actuators.head]
    kind = "turret"
    min_rad = -1.0
    max_rad = 1.5
    rate_rad_s = 6.0

    [robots.sensors.laser]
    kind = "laser"
    bearing_rad = 0.0
    opening_rad = 4.18
    rays = 682
    range_m = 4.0
    min_m = 0.02
    period_ms = 100.0
    port = { link = { kind = "ideal" } }
    noise = { multiplicative = 0.01 }

    [robots.sensors.sonar]
    kind = "sonar"
    mount = {}
    turret = "head"
    opening_rad = 0.3
    rays = 5
    min_m = 0.1
    max_m = 3.0

    [robots.sensors.satellites]
    kind = "gps"
    period_ms = 500.0
    sigma_m = 1.0
    port = { link = { kind = "uart", baud = 4800 }, sentences = "rmc" }

    [robots.sensors.camera]
    kind = "line-camera"
    bearing_rad = 0.0
    opening_rad = 1.5
    columns = 24
    rows = 3
    range_m = 4.0
    period_ms = 70.0
    port = { link = { kind = "ideal" } }
"#;

/// A robot whose brain is its microcontroller's program.
const LITTLE: &str = r#"
    end.after_s = 0.5
    [[robots]]
    name = "little"
    body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }
    sensors.heading = { kind = "compass" }
    link = { kind = "onboard" }
    microcontroller = { operations_per_s = 1e6, ram_bytes = 2048 }
"#;

/// A brain that looks ahead for half a second, then to the left, and creeps on.
struct Look;

impl Brain for Look {
    fn step(&mut self, turn: &Turn) -> Action {
        let creep = Action::drive(0.1, 0.12);
        match turn.tick {
            0 => creep.with_others(vec![0.5, 0.0]),
            50 => creep.with_others(vec![0.0, 1.0]),
            _ => creep,
        }
    }
}

async fn scout() -> (Server, Client) {
    let server = serve(scenario(SCOUT, &[]), lockstep()).await;
    let client = client(&server).await;
    (server, client)
}

#[tokio::test]
async fn a_brain_learns_of_its_turret_its_laser_and_its_ports() {
    let (server, client) = scout().await;
    let robot = client.attach("w", "scout").await.unwrap();
    let body = robot.body();
    assert_eq!((body.motor_kind.name(), body.onboard, body.ram_bytes), ("dc", false, None));
    let actuators: Vec<_> = body.actuators.iter().map(|a| (a.name.as_str(), a.kind.name())).collect();
    assert_eq!(actuators, [("lamp", "lamp"), ("head", "turret")]);
    assert_eq!(body.actuators[1].range_rad, Some([-1.0, 1.5]));
    let sensors: Vec<_> = body.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
    assert_eq!(sensors, ["sonar", "laser", "satellites", "camera"], "those on the wire first");
    assert_eq!(body.sensors[0].mount.unwrap().turret, body.actuator_index("head"));
    let laser = &body.sensors[1];
    assert_eq!((laser.components.len(), laser.values(), laser.period_ns), (1, 682, 100_000_000));
    let port = laser.port.as_ref().unwrap();
    assert_eq!((port.format.name(), port.baud), ("scip2", None));
    let nmea = body.sensors[2].port.as_ref().unwrap();
    assert_eq!((nmea.format.name(), nmea.baud), ("nmea", Some(4800)));
    assert_eq!(body, &std::sync::Arc::new(baudbot_client::Body::from(&scenario(SCOUT, &[]).robots[0])));
    server.shutdown().await;
}

#[tokio::test]
async fn a_turned_head_looks_elsewhere_and_the_scan_has_nothing_where_nothing_is() {
    let (server, client) = scout().await;
    let mut robot = client.attach("w", "scout").await.unwrap();
    let mut sonar = Vec::new();
    let mut scans = 0;
    while let Some(turn) = robot.turn().await.unwrap() {
        sonar.extend(turn.value("sonar"));
        if let Some(scan) = turn.reading("laser").filter(|reading| reading.readable) {
            scans += 1;
            assert_eq!(scan.values.len(), 682);
            assert!((0.7..1.0).contains(&scan.values[341]), "the box: {}", scan.values[341]);
            let nothing = scan.values.iter().filter(|&&value| value == -1.0).count();
            assert!((100..500).contains(&nothing), "{nothing} rays without anything");
        }
        robot.act(Look.step(&turn)).await.unwrap();
    }
    assert!(scans >= 9, "{scans}");
    // The sonar has the box before the head turns; at the end the ball.
    assert!((0.9..1.0).contains(&sonar[20]), "{}", sonar[20]);
    let last = *sonar.last().unwrap();
    assert!((0.3..0.5).contains(&last), "{last}");
    server.shutdown().await;
}

#[tokio::test]
async fn signals_that_are_left_out_stay_in_force_and_the_truth_shows_them() {
    let (server, client) = scout().await;
    let mut observer = ObserveServiceClient::new(server.channel().await.unwrap());
    let watch =
        v1::WatchRequest { world: "w".into(), every_ticks: 100, details: Vec::new(), ..Default::default() };
    let mut frames = observer.watch(watch).await.unwrap().into_inner();
    run(&mut client.attach("w", "scout").await.unwrap(), &mut Look).await.unwrap();
    let first = frames.message().await.unwrap().unwrap();
    assert_eq!(first.robots[0].actuators, [v1::ActuatorTruth::default(); 2]);
    let mut last = first;
    while last.ending.is_empty() {
        last = frames.message().await.unwrap().unwrap();
    }
    let truth = &last.robots[0];
    let expected =
        [(0.0, 0.0), (1.0, 1.5)].map(|(signal, angle_rad)| v1::ActuatorTruth { signal, angle_rad });
    assert_eq!(truth.actuators, expected);
    let battery = truth.battery.unwrap();
    assert!(battery.charge < 1.0 && battery.used_j > 1.0 && battery.voltage_v > 4.0, "{battery:?}");
    assert_eq!(truth.in_zone_ns, [1_000_000_000]);
    let things: Vec<_> = last.things.iter().map(|thing| thing.thing.as_str()).collect();
    assert_eq!(things, ["door", "ball"]);
    assert!(last.things[0].blocked_ns > 100_000_000, "{:?}", last.things[0]);
    server.shutdown().await;
}

#[tokio::test]
async fn an_observer_can_draw_all_that_there_is() {
    let (server, _) = scout().await;
    let mut observer = ObserveServiceClient::new(server.channel().await.unwrap());
    let request = v1::DescribeWorldRequest { world: "w".into() };
    let world = observer.describe_world(request).await.unwrap().into_inner();
    let low = &world.polygons[0];
    assert_eq!((low.closed, low.look.unwrap().height_m, low.look.unwrap().red), (true, Some(0.5), 200));
    assert!(!world.polygons[1].closed);
    assert_eq!(world.polygons[1].look.unwrap().height_m, None);
    assert_eq!((world.things[0].movable, world.things[1].movable), (false, true));
    assert_eq!(world.things[0].outline.clone().unwrap().points.len(), 4);
    assert_eq!(world.things[1].outline.clone().unwrap().radius_m, 0.1);
    assert_eq!((world.zones[0].zone.as_str(), world.zones[0].goal), ("home", true));
    assert_eq!((world.lights[0].light.as_str(), world.fields[0].field.as_str()), ("lamp", "scent"));
    let columns = &world.robots[0].sensor_columns;
    assert_eq!(
        (columns[0].as_str(), columns[1].as_str(), columns[682].as_str()),
        ("sonar", "laser.0", "laser.681")
    );
    server.shutdown().await;
}

#[tokio::test]
async fn an_operator_is_told_what_the_ports_carried_and_what_was_scored() {
    let (server, client) = scout().await;
    run(&mut client.attach("w", "scout").await.unwrap(), &mut Look).await.unwrap();
    let status = status(&server).await;
    let score = status.score.unwrap();
    assert!(score.covered.unwrap() > 0.0 && score.sensed.is_none(), "{score:?}");
    assert_eq!((score.goals_reached, score.goals, score.zones[0].visited), (1, 1, true));
    assert_eq!((status.movers.len(), status.movers[0].mover.as_str()), (1, "door"));
    let robot = &status.robots[0];
    assert!(robot.battery.unwrap().used_j > 1.0);
    assert_eq!(robot.in_zone_ns, [1_000_000_000]);
    assert_eq!(robot.sensors[0].port, None);
    let laser = robot.sensors[1].port.unwrap();
    assert!(laser.messages >= 9 && laser.bytes > 9 * 2000, "{laser:?}");
    assert_eq!(robot.sensors[2].port.unwrap().messages, 2);
    server.shutdown().await;
}

#[tokio::test]
async fn the_same_run_in_process_and_over_grpc() {
    let mut local = InProcess::with_brain(scenario(SCOUT, &[]), Look);
    local.run(u64::MAX);
    local.world.begin();
    let (server, client) = scout().await;
    run(&mut client.attach("w", "scout").await.unwrap(), &mut Look).await.unwrap();
    assert_eq!(status(&server).await.state_hash, local.world.hash());
    server.shutdown().await;
}

/// A brain that notes its turns.
struct Notebook(Vec<Turn>);

impl Brain for Notebook {
    fn step(&mut self, turn: &Turn) -> Action {
        self.0.push(turn.clone());
        Look.step(turn)
    }
}

#[tokio::test]
async fn a_raw_brain_reads_the_scan_itself_and_its_codec_sees_what_a_brain_of_messages_sees() {
    let (server, client) = scout().await;
    let mut messages = Notebook(Vec::new());
    run(&mut client.attach("w", "scout").await.unwrap(), &mut messages).await.unwrap();
    let expected = status(&server).await.state_hash;
    server.shutdown().await;

    let (server, client) = scout().await;
    let mut robot = client.attach_raw("w", "scout").await.unwrap();
    let mut readings = RawReadings::new(robot.body().clone()).unwrap();
    let mut commands = RawCommands::new(robot.body()).unwrap();
    let mut seen = Notebook(Vec::new());
    let (mut stream, mut scans) = (Vec::new(), 0);
    while let Some(raw) = robot.turn().await.unwrap() {
        stream.extend_from_slice(raw.port(1));
        while let Some(end) = scip::message_end(&stream) {
            let scan = scip::parse(&stream[..end]).expect("a whole scan");
            assert_eq!(scan.ranges_mm().len(), 682);
            stream.drain(..end);
            scans += 1;
        }
        let action = seen.step(&readings.turn(&raw));
        let bytes = commands.command_with(action.signals.unwrap(), &action.others);
        robot.write(&bytes).await.unwrap();
    }
    assert!(scans >= 9, "{scans}");
    assert_eq!(seen.0.len(), messages.0.len());
    for (raw, message) in seen.0.iter().zip(&messages.0) {
        assert_eq!(raw, message);
    }
    assert!(seen.0.iter().any(|turn| turn.reading("satellites").is_some()));
    let image = seen.0.iter().find_map(|turn| turn.reading("camera")).unwrap();
    assert_eq!(image.values.len(), 4 * 24);
    assert!(image.values[12] > 0.7 && image.values[24 + 12] == 0.0, "the box is red: {image:?}");
    assert_eq!(status(&server).await.state_hash, expected);
    server.shutdown().await;
}

/// The error with which the server answers a step.
async fn refusal(toml: &str, robot: &str, action: Action) -> (Code, String) {
    let server = serve(scenario(toml, &[]), lockstep()).await;
    let mut robot = client(&server).await.attach("w", robot).await.unwrap();
    robot.turn().await.unwrap().unwrap();
    robot.act(action).await.unwrap();
    let Err(Error::Status { code, message }) = robot.turn().await else { panic!("it was not refused") };
    server.shutdown().await;
    (code, message)
}

#[tokio::test]
async fn what_makes_no_sense_is_refused_with_its_field() {
    let still = || Action::drive(0.0, 0.0);
    let cases = [
        (
            SCOUT,
            "scout",
            still().with_others(vec![1.0]),
            "command.other_signals: has 1 signals, but `scout` has 2",
        ),
        (
            SCOUT,
            "scout",
            still().with_others(vec![f64::NAN, 0.0]),
            "command.other_signals: must be a finite number",
        ),
        (
            LITTLE,
            "little",
            still().with_others(vec![0.0]),
            "command.other_signals: has 1 signals, but `little` has 0",
        ),
        (SCOUT, "scout", still().operations(5), "operations: `scout` is not onboard"),
        (LITTLE, "little", still().operations(5).after(std::time::Duration::ZERO), "operations: give either"),
        (LITTLE, "little", still().operations(u64::MAX), "operations: 18446744073709551615 would take"),
    ];
    for (toml, robot, action, expected) in cases {
        let (code, message) = refusal(toml, robot, action).await;
        assert_eq!(code, Code::InvalidArgument, "{message}");
        assert!(message.starts_with(&format!("step.robots[0].{expected}")), "{message}");
    }
}

/// A brain that publishes the number of its steps, each time a little more.
struct Diligent(u64);

impl Brain for Diligent {
    fn step(&mut self, _: &Turn) -> Action {
        self.0 += 1_000;
        Action::drive(0.1, -0.1).operations(self.0)
    }
}

#[tokio::test]
async fn operations_of_a_brain_on_board_take_the_microcontrollers_time() {
    let server = serve(scenario(LITTLE, &[]), lockstep()).await;
    let mut robot = client(&server).await.memory_bytes(2048).attach("w", "little").await.unwrap();
    let body = robot.body();
    assert_eq!((body.onboard, body.operations_per_s, body.ram_bytes), (true, Some(1e6), Some(2048)));
    let first = robot.turn().await.unwrap().unwrap();
    robot.act(Action::wait().operations(25_000)).await.unwrap();
    let second = robot.turn().await.unwrap().unwrap();
    assert!(second.at_ns >= first.at_ns + 25_000_000, "{} to {}", first.at_ns, second.at_ns);
    assert_eq!(second.tick, 2, "it thought through a tick");
    server.shutdown().await;

    let mut local = InProcess::with_brain(scenario(LITTLE, &[]), Diligent(0));
    local.run(u64::MAX);
    local.world.begin();
    let server = serve(scenario(LITTLE, &[]), lockstep()).await;
    let mut robot = client(&server).await.attach("w", "little").await.unwrap();
    run(&mut robot, &mut Diligent(0)).await.unwrap();
    assert_eq!(status(&server).await.state_hash, local.world.hash());
    server.shutdown().await;
}

#[tokio::test]
async fn a_program_that_does_not_fit_is_refused() {
    for (toml, robot, bytes, expected) in [
        (
            LITTLE,
            "little",
            2049,
            (Code::ResourceExhausted, "needs 2049 bytes, but the microcontroller of robot `little` has 2048"),
        ),
        (SCOUT, "scout", 1, (Code::InvalidArgument, "hello.memory_bytes: robot `scout` is not onboard")),
    ] {
        let server = serve(scenario(toml, &[]), lockstep()).await;
        let refused = client(&server).await.memory_bytes(bytes).attach("w", robot).await;
        let Err(Error::Status { code, message }) = refused else { panic!("it was not refused") };
        assert!(code == expected.0 && message.contains(expected.1), "{code:?}: {message}");
        // The robot is still free.
        client(&server).await.attach("w", robot).await.unwrap();
        server.shutdown().await;
    }
}

#[tokio::test]
async fn what_was_last_sent_goes_back_in_time_with_the_world() {
    let server = serve(scenario(SCOUT, &[]), Pace::Stepped(Lockstep::default())).await;
    let mut robot = client(&server).await.attach("w", "scout").await.unwrap();
    let brain = tokio::spawn(async move {
        while let Some(turn) = robot.turn().await? {
            let others = match turn.tick {
                0 => vec![0.5, 1.0],
                30 => vec![0.0, -1.0],
                _ => Vec::new(),
            };
            robot.act(Action::drive(0.0, 0.0).with_others(others)).await?;
        }
        Ok::<_, Error>(())
    });
    let mut operator = operator(&server).await;
    let world = || "w".to_owned();
    let step = |ticks| v1::StepWorldRequest { world: world(), ticks };
    operator.step_world(step(20)).await.unwrap();
    let kept = operator.snapshot_world(v1::SnapshotWorldRequest { world: world() }).await.unwrap();
    operator.step_world(step(20)).await.unwrap();
    assert_eq!(signals(&server).await, [0.0, -1.0]);
    let snapshot = kept.into_inner().snapshot;
    operator.restore_world(v1::RestoreWorldRequest { world: world(), snapshot }).await.unwrap();
    operator.step_world(step(5)).await.unwrap();
    assert_eq!(signals(&server).await, [0.5, 1.0]);
    server.shutdown().await;
    brain.await.unwrap().unwrap_err();
}

/// The signals in force on the scout's actuators.
async fn signals(server: &Server) -> Vec<f64> {
    let mut observer = ObserveServiceClient::new(server.channel().await.unwrap());
    let watch =
        v1::WatchRequest { world: "w".into(), every_ticks: 1, details: Vec::new(), ..Default::default() };
    let frame = observer.watch(watch).await.unwrap().into_inner().message().await.unwrap().unwrap();
    frame.robots[0].actuators.iter().map(|actuator| actuator.signal).collect()
}

#[tokio::test]
async fn a_new_brain_finds_the_actuators_as_the_last_one_left_them() {
    let (server, client) = scout().await;
    let mut first = client.attach("w", "scout").await.unwrap();
    for _ in 0..10 {
        first.turn().await.unwrap().unwrap();
        first.act(Action::drive(0.0, 0.0).with_others(vec![0.5, 1.0])).await.unwrap();
    }
    first.turn().await.unwrap().unwrap();
    drop(first);
    let mut second = loop {
        match client.attach("w", "scout").await {
            Ok(robot) => break robot,
            Err(_) => tokio::task::yield_now().await,
        }
    };
    while second.turn().await.unwrap().is_some() {
        second.drive(Signals::default()).await.unwrap();
    }
    assert_eq!(signals(&server).await, [0.5, 1.0]);
    server.shutdown().await;
}

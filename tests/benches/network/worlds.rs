//! This process: a server with one world, and the other process that is started for it.

use std::time::{Duration, Instant};

use baudbot_proto::v1;
use baudbot_server::{Address, Pace, Server, WorldConfig};
use baudbot_sim::Scenario;
use baudbot_tests::system::{lockstep as waiting, status, strict};
use baudbot_tests::{ARSIM, WANDER, scenario};

use crate::figures;

/// How the brains' process holds the robots.
pub(crate) struct Load {
    pub(crate) connections: usize,
    pub(crate) streams: usize,
    pub(crate) ticks: u64,
}

/// How real time was kept.
pub(crate) struct Outcome {
    pub(crate) on_time: f64,
    pub(crate) within_1_ms: f64,
    pub(crate) most_late_ns: u64,
    pub(crate) server_cpu: f64,
    pub(crate) brains_cpu: f64,
    pub(crate) lost: u64,
}

/// ARSim's robot: two infra-red sensors and an odometer, an ideal link.
pub(crate) fn lone() -> Scenario {
    let toml = ARSIM.replace("name = \"robot\"", "name = \"r0000\"");
    scenario(&toml, &["end={}", "collision=stop-robot"])
}

/// Five infra-red sensors that send 50 times a second over 9600 baud, and ticks of 1 ms.
pub(crate) fn slow() -> Scenario {
    let toml = WANDER.replace("name = \"robot\"", "name = \"r0000\"");
    scenario(&toml, &["end={}", "collision=stop-robot", "step_ms=1.0", "substeps=1"])
}

/// So many small robots with eight infra-red sensors and encoders, four a square metre.
pub(crate) fn crowd(robots: usize) -> Scenario {
    let columns = (robots as f64).sqrt().ceil();
    let half = columns * SPACING_M / 2.0;
    let mut toml = format!(
        "step_ms = 10.0\ncollision = \"stop-robot\"\n[[arena.polygons]]\nname = \"border\"\nsolid = false\n\
         points_m = [[-{half}, -{half}], [{half}, -{half}], [{half}, {half}], [-{half}, {half}]]\n"
    );
    for robot in 0..robots {
        let (row, column) = ((robot as f64 / columns).floor(), robot as f64 % columns);
        let place = |i: f64| (i + 0.5) * SPACING_M - half;
        toml += &format!(
            "[[robots]]\nname = \"r{robot:04}\"\nstart = {{ x_m = {}, y_m = {}, heading_rad = {} }}\n{ROBOT}",
            place(column),
            place(row),
            robot % 6
        );
        for (i, (x, y, degrees)) in EYES.iter().enumerate() {
            let heading = f64::to_radians(*degrees);
            toml += &format!(
                "[robots.sensors.ir_{i}]\nkind = \"ir\"\nmount = {{ x_m = {x}, y_m = {y}, heading_rad = {heading} }}\n{EYE}"
            );
        }
        toml += "[robots.sensors.encoders]\nkind = \"encoders\"\ncounts_per_turn = 1000\n";
    }
    scenario(&toml, &[])
}

const SPACING_M: f64 = 0.5;

const ROBOT: &str = "body = { radius_m = 0.035, mass_kg = 0.15, inertia_kg_m2 = 9.2e-5, wheel_radius_m = 0.02 }\n\
                     motors = { preset = \"e-puck-stepper\" }\n";

const EYE: &str = "rays = 3\nopening_rad = 0.5236\nrange_m = 0.12\nc1_m2 = 0.0005\nc2 = 0.1\nsigma = 0.02\n";

const EYES: [(f64, f64, f64); 8] = [
    (0.0335, -0.0105, -18.0),
    (0.023, -0.026, -45.0),
    (0.0, -0.033, -90.0),
    (-0.030, -0.018, -142.0),
    (-0.030, 0.018, 142.0),
    (0.0, 0.033, 90.0),
    (0.023, 0.026, 45.0),
    (0.0335, 0.0105, 18.0),
];

async fn serve(scenario: Scenario, pace: Pace) -> (Server, String) {
    let loopback: Address = "127.0.0.1:0".parse().expect("an address");
    let builder = Server::builder().world(WorldConfig::new("w", scenario).pace(pace)).listen(loopback);
    let server = builder.serve().await.expect("a server");
    let address = server.addresses()[0].to_string();
    (server, address)
}

/// Ticks a second.
pub(crate) async fn lockstep(scenario: Scenario, load: &Load, brain: &str, lookahead: bool) -> f64 {
    let robots = scenario.robots().len();
    let (server, address) = serve(scenario, if lookahead { waiting() } else { strict() }).await;
    let said = drive(&address, robots, load, load.ticks, brain).await;
    server.shutdown().await;
    said
}

/// How real time is kept for so many ticks.
pub(crate) async fn real_time(scenario: Scenario, load: &Load) -> Outcome {
    let robots = scenario.robots().len();
    let (server, address) = serve(scenario, Pace::REAL_TIME).await;
    let (begun, cpu) = (Instant::now(), figures::cpu_s());
    let brains = tokio::spawn({
        let (connections, streams) = (load.connections, load.streams);
        let address = address.clone();
        async move { drive(&address, robots, &Load { connections, streams, ticks: 0 }, 0, "constant").await }
    });
    tokio::time::sleep(Duration::from_millis(10 * load.ticks)).await;
    let (status, wall_s) = (status(&server).await, begun.elapsed().as_secs_f64());
    let server_cpu = (figures::cpu_s() - cpu) / wall_s;
    server.shutdown().await;
    let brains_cpu = brains.await.expect("brains") / wall_s;
    outcome(&status, server_cpu, brains_cpu)
}

fn outcome(status: &v1::WorldStatus, server_cpu: f64, brains_cpu: f64) -> Outcome {
    let pacing = status.pacing.clone().unwrap_or_default();
    let ticks = status.tick as f64;
    let prompt: u64 = pacing.lateness_us_log2.iter().take(11).sum();
    Outcome {
        on_time: 1.0 - pacing.late_ticks as f64 / ticks,
        within_1_ms: prompt as f64 / ticks,
        most_late_ns: pacing.lateness_max_wall_ns,
        server_cpu,
        brains_cpu,
        lost: status.robots.iter().map(|robot| robot.lost_deliveries).sum(),
    }
}

async fn drive(address: &str, robots: usize, load: &Load, ticks: u64, brain: &str) -> f64 {
    let numbers = [robots, load.connections, load.streams, ticks as usize].map(|number| number.to_string());
    let [robots, connections, streams, ticks] = numbers.each_ref().map(String::as_str);
    let said = brains_process(&["drive", address, robots, connections, streams, ticks, brain]).await;
    said.parse().expect("a number")
}

/// Runs this program as the brains' process, and gives what it says.
pub(crate) async fn brains_process(arguments: &[&str]) -> String {
    let program = std::env::current_exe().expect("this program");
    let mut command = std::process::Command::new(program);
    command.arg("brains").args(arguments);
    command.stderr(std::process::Stdio::inherit());
    let output =
        tokio::task::spawn_blocking(move || command.output()).await.expect("no panic").expect("a process");
    assert!(output.status.success(), "the brains' process failed");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

//! The original ARSim's trajectories, row by row: in process to 1e-12, through gRPC in lockstep to 1e-9.
//! `tests/golden/README.md` has the origin of the rows.

use std::f64::consts::{PI, TAU};
use std::sync::mpsc;

use baudbot_server::{Server, WorldConfig};
use baudbot_sim::World;
use baudbot_tests::{ARSIM, InProcess, scenario, system};

struct Golden {
    csv: &'static str,
    start: [f64; 3],
    brain: &'static str,
    rows: usize,
}

const GOLDENS: [Golden; 4] = [
    Golden {
        csv: include_str!("../golden/arsim/g1_straight.csv"),
        start: [-1.5, -1.5, PI / 4.0],
        brain: "constant:left=0.5,right=0.5",
        rows: 1001,
    },
    Golden {
        csv: include_str!("../golden/arsim/g2_spin.csv"),
        start: [-0.2, 0.0, 0.0],
        brain: "constant:left=0.7,right=-0.7",
        rows: 1001,
    },
    Golden {
        csv: include_str!("../golden/arsim/g3_arc.csv"),
        start: [-0.2, 0.0, 0.0],
        brain: "constant:left=0.3,right=0.5",
        rows: 900,
    },
    Golden {
        csv: include_str!("../golden/arsim/g4_navigate1m.csv"),
        start: [-0.2, 0.0, 0.0],
        brain: "navigate",
        rows: 1001,
    },
];

impl Golden {
    fn changes(&self) -> Vec<String> {
        let [x, y, heading] = self.start;
        vec![
            "noise=false".into(),
            format!("robots.robot.start.x_m={x:?}"),
            format!("robots.robot.start.y_m={y:?}"),
            format!("robots.robot.start.heading_rad={heading:?}"),
        ]
    }

    /// t, x, y, heading, V, ω, ir1, ir2, signals, collided; the odometer's row is that of the step that
    /// follows, as ARSim reads it before it moves.
    fn rows(&self) -> Vec<Row> {
        let table: Vec<Vec<f64>> = self
            .csv
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
            .collect();
        let row = |(k, row): (usize, &Vec<f64>)| {
            let odometer = table.get(k + 1).map(|next| [next[14], next[15], next[16]]);
            Row {
                columns: [row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9]],
                odometer,
                collided: row[17] != 0.0,
            }
        };
        table.iter().enumerate().map(row).collect()
    }
}

struct Row {
    columns: [f64; 10],
    odometer: Option<[f64; 3]>,
    collided: bool,
}

const NAMES: [&str; 10] = ["t", "x", "y", "heading", "V", "omega", "ir1", "ir2", "left", "right"];

fn row_of(world: &World) -> Row {
    let robot = world.robot(0);
    let (motion, signals) = (robot.motion(), robot.signals());
    let sensors: Vec<_> = robot.sensors().map(|sensor| sensor.sample.to_vec()).collect();
    Row {
        columns: [
            world.time().as_seconds(),
            motion.pose.position.x,
            motion.pose.position.y,
            motion.pose.heading,
            motion.speed_m_s,
            motion.turn_rate_rad_s,
            sensors[0][0],
            sensors[1][0],
            signals.left,
            signals.right,
        ],
        odometer: Some([sensors[2][0], sensors[2][1], sensors[2][2]]),
        collided: robot.collided(),
    }
}

#[track_caller]
fn compare(golden: &Golden, rows: &[Row], tolerance: f64) {
    let expected = golden.rows();
    assert_eq!(expected.len(), golden.rows);
    assert_eq!(rows.len(), golden.rows, "{}", golden.brain);
    for (k, (found, expected)) in rows.iter().zip(&expected).enumerate() {
        for (i, name) in NAMES.iter().enumerate() {
            let wraps = *name == "heading";
            check(golden, k, name, found.columns[i], expected.columns[i], wraps, tolerance);
        }
        if let (Some(found), Some(expected)) = (found.odometer, expected.odometer) {
            for i in 0..3 {
                check(golden, k, "odometer", found[i], expected[i], i == 2, tolerance);
            }
        }
        assert_eq!(found.collided, expected.collided, "{} row {k}", golden.brain);
    }
}

#[track_caller]
fn check(golden: &Golden, row: usize, name: &str, found: f64, expected: f64, wraps: bool, tolerance: f64) {
    let difference = (found - expected).abs();
    let difference = if wraps { difference.min((difference - TAU).abs()) } else { difference };
    assert!(difference <= tolerance, "{} row {row} {name}: {found} is not {expected}", golden.brain);
}

/// The oracle of ARSim's own program: motors by (1.8)–(1.10) and §3.2.4, wheels and odometer by (2.1)–(2.3) and (2.5)–(2.9), forces by (2.31), (2.32),
/// infra-red sensors by (3.9), (3.10), (3.12), (3.13), motion by (3.16)–(3.22), collisions by §3.2.5; the fourth drives by (5.1), listings 5.3 and 5.4.
#[test]
fn in_process_to_1e_12() {
    for golden in &GOLDENS {
        let changes = golden.changes();
        let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        let mut local = InProcess::new(scenario(ARSIM, &changes), golden.brain).unwrap();
        let mut rows = Vec::new();
        while local.world.ending().is_none() {
            local.tick(|world| rows.push(row_of(world)));
        }
        local.world.begin();
        rows.push(row_of(&local.world));
        compare(golden, &rows, 1e-12);
    }
}

#[tokio::test]
async fn through_grpc_in_lockstep_to_1e_9() {
    for golden in &GOLDENS {
        let changes = golden.changes();
        let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        let (sender, rows) = mpsc::channel();
        let on_tick = Box::new(move |world: &World| sender.send(row_of(world)).unwrap());
        let world =
            WorldConfig::new("w", scenario(ARSIM, &changes)).pace(system::lockstep()).on_tick(on_tick);
        let server = Server::builder().world(world).in_process().await.unwrap();
        system::drive(&system::client(&server).await, "robot", golden.brain, 1).await;
        server.shutdown().await;
        compare(golden, &rows.iter().collect::<Vec<_>>(), 1e-9);
    }
}

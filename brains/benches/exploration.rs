//! The duration of steps of exploration and SLAM in an office that is nearly explored, with a laser of 682 rays. Run
//! with `cargo bench -p baudbot-brains --bench exploration`.

use baudbot_brains::Chance;
use baudbot_brains::estimate::Estimate;
use baudbot_brains::exploration::{Command, Explorer, Frontiers, Input, Nodes, frontiers, nodes};
use baudbot_brains::localization::deskew::{Sweep, deskew};
use baudbot_brains::localization::{Map, VirtualLaser};
use baudbot_brains::mapping::{Occupancy, PlacedScan};
use baudbot_brains::scan::Scan;
use baudbot_brains::slam::{self, Slam};
use baudbot_geometry::{Direction, Point, Pose, Segment, angle};
use divan::Bencher;

fn main() {
    divan::main();
}

/// The office of `catalogue/scenarios/explore-office.toml`.
fn office() -> Map {
    let mut walls = vec![
        [4.5, 0.0, 4.5, 1.4],
        [4.5, 2.6, 4.5, 6.6],
        [4.5, 7.8, 4.5, 9.0],
        [8.0, 0.0, 8.0, 1.4],
        [8.0, 2.6, 8.0, 6.2],
        [8.0, 7.4, 8.0, 9.0],
        [4.5, 4.5, 5.6, 4.5],
        [6.8, 4.5, 8.0, 4.5],
    ];
    for [x, y, u, v] in [[0.0, 0.0, 12.0, 9.0], [10.0, 3.5, 11.0, 4.5], [1.0, 5.0, 1.8, 6.5]] {
        walls.extend([[x, y, u, y], [u, y, u, v], [u, v, x, v], [x, v, x, y]]);
    }
    let wall = |[x, y, u, v]: [f64; 4]| Segment { start: Point::new(x, y), end: Point::new(u, v) };
    Map::new(walls.into_iter().map(wall).collect(), Vec::new()).expect("finite")
}

/// A URG-04LX.
fn laser() -> VirtualLaser {
    VirtualLaser::like(&Scan {
        robot_from_laser: Pose::new(0.05, 0.0, 0.0),
        opening_rad: 681.0 * std::f64::consts::PI / 512.0,
        range_m: 4.0,
        distances_m: vec![0.0; 682],
    })
}

/// A scan with the noise of a URG-04LX.
fn scan(map: &Map, laser: &VirtualLaser, pose: &Pose, chance: &mut Chance) -> Scan {
    let mut scan = laser.scan(map, pose);
    scan.distances_m.iter_mut().for_each(|distance| *distance *= 1.0 + 0.004 * chance.normal());
    scan
}

/// The pose, 0.1 s later, of a robot that obeys a command.
fn moved(pose: &Pose, command: Command) -> Pose {
    let toward = |heading_rad: f64| {
        angle::wrap(pose.heading + angle::difference(heading_rad, pose.heading).clamp(-0.08, 0.08))
    };
    match command {
        Command::Turn { heading_rad } => Pose { heading: toward(heading_rad), ..*pose },
        Command::Drive { to } => {
            let path = to - pose.position;
            let heading = toward(path.y.atan2(path.x));
            let step_m = path.norm().min(0.03);
            Pose { position: pose.position + Direction::from_angle(heading).vector() * step_m, heading }
        }
        Command::Wait | Command::Done(_) | Command::Failed(_) => *pose,
    }
}

/// The last steps of an exploration, each with what the explorer knew before it, and the scan that it then got. Only those
/// in which it was under way.
fn last_steps<E: Explorer + Clone>(mut explorer: E, count: usize) -> Vec<(E, PlacedScan)> {
    let (map, laser, mut chance) = (office(), laser(), Chance::new(1, "scans"));
    let mut pose = Pose::new(1.0, 1.0, std::f64::consts::FRAC_PI_4);
    let mut steps = std::collections::VecDeque::new();
    for _ in 0..20_000 {
        let placed = PlacedScan::new(pose, scan(&map, &laser, &pose, &mut chance));
        if steps.len() == count {
            steps.pop_front();
        }
        steps.push_back((explorer.clone(), placed.clone()));
        let command = explorer.step(&Input { world_from_robot: pose, scan: Some(&placed), near: false });
        if matches!(command, Command::Done(_)) {
            break;
        }
        pose = moved(&pose, command);
    }
    steps.into()
}

fn bench_steps<E: Explorer + Clone>(bencher: Bencher<'_, '_>, explorer: E) {
    let steps = last_steps(explorer, 200);
    let mut next = steps.iter().cycle();
    bencher.with_inputs(|| next.next().expect("a step").clone()).bench_local_refs(|(explorer, placed)| {
        explorer.step(&Input { world_from_robot: placed.world_from_robot(), scan: Some(placed), near: false })
    });
}

#[divan::bench(sample_count = 200, sample_size = 1)]
fn step_by_nodes(bencher: Bencher<'_, '_>) {
    bench_steps(bencher, Nodes::new(nodes::Parameters::default()));
}

#[divan::bench(sample_count = 200, sample_size = 1)]
fn step_by_frontiers(bencher: Bencher<'_, '_>) {
    bench_steps(bencher, Frontiers::new(frontiers::Parameters::default()));
}

/// A map of the office, and a robot in the middle of it.
fn mapped() -> (Slam, Occupancy, Pose) {
    let (map, laser, mut chance) = (office(), laser(), Chance::new(1, "map"));
    let mut grid = Occupancy::new(slam::Parameters::default().cell_m);
    for (world_from_robot, _) in last_steps(Frontiers::new(frontiers::Parameters::default()), usize::MAX)
        .into_iter()
        .step_by(5)
        .map(|(_, placed)| (placed.world_from_robot(), placed.scan().clone()))
    {
        grid.add(&PlacedScan::new(world_from_robot, scan(&map, &laser, &world_from_robot, &mut chance)));
    }
    (Slam::new(slam::Parameters::default()), grid, Pose::new(6.0, 5.2, 0.4))
}

/// The error of the guess decides how much is searched: from afar it is the window.
#[divan::bench(args = [0.01, 0.3])]
fn slam_with_a_guess_that_is_off_by_m(bencher: Bencher<'_, '_>, off_m: f64) {
    let (slam, mut grid, truth) = mapped();
    let scan = scan(&office(), &laser(), &truth, &mut Chance::new(2, "scan"));
    let wrong = Pose::new(truth.position.x + off_m, truth.position.y - off_m, truth.heading + off_m);
    let guess = Estimate::within(wrong, off_m, off_m);
    bencher.with_inputs(|| slam.clone()).bench_local_refs(|slam| slam.see(&mut grid, &scan, &guess));
}

#[divan::bench]
fn deskew_of_682_rays(bencher: Bencher<'_, '_>) {
    let scan = scan(&office(), &laser(), &Pose::new(6.0, 5.2, 0.4), &mut Chance::new(2, "scan"));
    let sweep = Sweep { right_ns: 0, left_ns: 66_500_000 };
    let pose_at = |at_ns: u64| Some(Pose::new(6.0 + 3e-10 * at_ns as f64, 5.2, 0.4 + 8e-10 * at_ns as f64));
    bencher.bench_local(|| deskew(&scan, sweep, 66_500_000, pose_at));
}

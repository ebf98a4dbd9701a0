//! Arenas drawn at random.

use std::fmt::Write as _;

use baudbot_brains::Chance;
use baudbot_brains::navigation::{Floor, Method};
use baudbot_sim::Scenario;
use baudbot_tests::scenario;

use super::HALL;

/// Walls `[x, y, x, y]`, pillars `[x, y, radius]`, and the size of the whole.
pub(super) struct Arena {
    size_m: [f64; 2],
    pub(super) walls: Vec<[f64; 4]>,
    pub(super) pillars: Vec<[f64; 3]>,
}

impl Arena {
    fn new(size_m: [f64; 2]) -> Self {
        let [x, y] = size_m;
        let walls = vec![[0.0, 0.0, x, 0.0], [x, 0.0, x, y], [x, y, 0.0, y], [0.0, y, 0.0, 0.0]];
        Self { size_m, walls, pillars: Vec::new() }
    }

    /// A wall across at this x, with a door.
    fn divide(&mut self, x: f64, [from, to]: [f64; 2], chance: &mut Chance) {
        let width = 0.9 + 0.4 * chance.uniform();
        let door = from + 0.3 + (to - from - width - 0.6) * chance.uniform();
        self.walls.extend([[x, from, x, door], [x, door + width, x, to]]);
    }

    /// Three rooms, each with a table.
    pub(super) fn office(chance: &mut Chance) -> Self {
        let mut arena = Self::new([9.0, 5.0]);
        for x in [3.0, 6.0] {
            arena.divide(x, [0.0, 5.0], chance);
        }
        for room in [0.0, 3.0, 6.0] {
            let (x, y) = (room + 0.8 + 0.6 * chance.uniform(), 0.9 + 2.4 * chance.uniform());
            let (u, v) = (x + 0.3 + 0.5 * chance.uniform(), y + 0.3 + 0.5 * chance.uniform());
            arena.walls.extend([[x, y, u, y], [u, y, u, v], [u, v, x, v], [x, v, x, y]]);
        }
        arena
    }

    /// A corridor that winds round four walls.
    pub(super) fn corridor(chance: &mut Chance) -> Self {
        let mut arena = Self::new([7.5, 2.5]);
        for i in 0..4 {
            let (x, gap) = (1.5 * f64::from(i + 1), 0.8 + 0.5 * chance.uniform());
            arena.walls.push(if i % 2 == 0 { [x, 0.0, x, 2.5 - gap] } else { [x, gap, x, 2.5] });
        }
        arena
    }

    /// A room with pillars, each 1.3 m from the next, middle to middle.
    pub(super) fn pillars(chance: &mut Chance) -> Self {
        let mut arena = Self::new([7.0, 6.0]);
        for _ in 0..200 {
            let [x, y] = [1.0 + 5.0 * chance.uniform(), 1.0 + 4.0 * chance.uniform()];
            let far = |u: f64, v: f64, least_m: f64| (x - u).hypot(y - v) > least_m;
            let is_free = far(0.7, 0.7, 0.9) && far(6.3, 5.3, 0.9) && far(5.5, 1.0, 0.7);
            if is_free && arena.pillars.len() < 8 && arena.pillars.iter().all(|&[u, v, _]| far(u, v, 1.3)) {
                arena.pillars.push([x, y, 0.1 + 0.15 * chance.uniform()]);
            }
        }
        arena
    }

    /// A straight corridor with pillars at its sides.
    pub(super) fn aisle(chance: &mut Chance) -> Self {
        let mut arena = Self::new([9.0, 2.2]);
        for i in 0..4 {
            let side = if i % 2 == 0 { 0.3 } else { 1.9 };
            arena.pillars.push([2.0 + 1.5 * f64::from(i), side + 0.2 * chance.uniform() - 0.1, 0.25]);
        }
        arena
    }

    /// A place where a body has 0.35 m of room, and from which such a way leads to the others.
    pub(super) fn place(&self, chance: &mut Chance, to: Option<[f64; 2]>) -> [f64; 2] {
        let floor = Floor::new(&self.walls, 0.05, 0.35, Method::ThetaStar).unwrap();
        loop {
            let [x, y] = self.size_m.map(|m| m * chance.uniform());
            let is_reached = |[u, v]: [f64; 2]| {
                let far = (x - u).hypot(y - v) > 0.4 * self.size_m[0];
                far && floor.path([x, y].into(), [u, v].into()).is_ok()
            };
            if floor.is_free([x, y].into()) && to.is_none_or(is_reached) {
                return [x, y];
            }
        }
    }

    /// The robot of the hall in this arena, with what else there is.
    pub(super) fn scenario(&self, start: [f64; 2], seed: u64, more: &str) -> Scenario {
        let (_, robot) = HALL.split_once("[[robots]]").expect("a robot");
        // The odometer is exact, as this test is of the way alone.
        self.scenario_of(&robot.replace("sigma_m = 0.0001", "sigma_m = 0.0"), start, seed, more)
    }

    /// The same with another robot, whose start has a line of its own.
    pub(super) fn scenario_of(&self, robot: &str, start: [f64; 2], seed: u64, more: &str) -> Scenario {
        let mut toml =
            format!("name = \"random\"\nstep_ms = 10.0\ncollision = \"stop-robot\"\nseed = {seed}\n");
        for (i, [x, y, u, v]) in self.walls.iter().enumerate() {
            let _ = writeln!(
                toml,
                "[[arena.polygons]]\nname = \"wall{i}\"\nsolid = false\nclosed = false\n\
                 points_m = [[{x:?}, {y:?}], [{u:?}, {v:?}]]"
            );
        }
        for (i, [x, y, radius]) in self.pillars.iter().enumerate() {
            let _ = writeln!(
                toml,
                "[[arena.circles]]\nname = \"pillar{i}\"\nx_m = {x:?}\ny_m = {y:?}\nradius_m = {radius:?}"
            );
        }
        let (before, rest) = robot.split_once("start = {").expect("a start");
        let (_, after) = rest.split_once('\n').expect("a line of its own");
        let place = format!("start = {{ x_m = {:?}, y_m = {:?} }}", start[0], start[1]);
        scenario(&format!("{toml}\n{more}\n[[robots]]\n{before}{place}\n{after}"), &[])
    }
}

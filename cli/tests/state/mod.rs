//! Worlds that outlive their server: `baudbot serve --state`, killed and started again.

mod brains;
mod descriptors;
mod disk;
mod folder;
mod kills;
mod operator;
mod released;
mod server;
mod stopping;

use std::path::{Path, PathBuf};

use baudbot_scenario::Override;
use baudbot_sim::Scenario;

const WANDER: &str = include_str!("../../../catalogue/scenarios/wander.toml");

/// A path that is not there yet, in a folder of this test's own.
fn place(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("state").join(name);
    let _ = std::fs::remove_dir_all(&path);
    let _ = std::fs::remove_file(&path);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    path
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn parse(toml: &str, changes: &[&str]) -> Scenario {
    let changes: Vec<_> = changes.iter().map(|text| Override::parse(text).unwrap()).collect();
    baudbot_scenario::parse_with(toml, &changes).unwrap()
}

/// Robots side by side in a large room.
fn crowd(robots: usize) -> String {
    let (_, robot) = WANDER.split_once("[[robots]]").unwrap();
    let mut toml = String::from(
        "name = \"crowd\"\nstep_ms = 10.0\nsubsteps = 10\ncollision = \"stop-robot\"\n\
         [[arena.polygons]]\nname = \"border\"\nsolid = false\npoints_m = [[-9, -9], [9, -9], [9, 9], [-9, 9]]\n",
    );
    for i in 0..robots {
        let (x, y) = ((i % 8) as f64 * 2.0 - 7.0, (i / 8) as f64 * 2.0 - 7.0);
        let start = format!("start = {{ x_m = {x:?}, y_m = {y:?}, heading_rad = {i}.5 }}");
        let own = robot
            .replace("name = \"robot\"", &format!("name = \"r{i:02}\""))
            .replace("start = { x_m = -0.2, y_m = 0.0, heading_rad = 0.0 }", &start);
        assert!(own.contains(&start), "wander.toml's start line has changed");
        toml += "[[robots]]";
        toml += &own;
    }
    toml
}

/// Numbers by chance, so that a run can be repeated.
struct Chance(u64);

impl Chance {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % limit
    }
}

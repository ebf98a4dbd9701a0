//! Narrow arenas for bodies of any size: corridors, doors and gaps that are some times as wide as the body, a robot for them,
//! and what can be seen there. `cargo run -p baudbot-tests --example explore_narrow` runs the whole table.

mod shapes;
mod truth;

use std::fmt::Write;

use baudbot_sim::Scenario;

use crate::InProcess;
pub use truth::Truth;

/// The layout of an arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A corridor, straight on.
    Straight,
    /// A corridor round right corners, to and fro.
    Serpentine,
    /// A corridor that bends by 80 degrees, to and fro.
    Zigzag,
    /// A corridor with teeth.
    Comb,
    /// Five corridors from one place.
    Star,
    /// A corridor around a square island.
    Ring,
    /// A corridor around a round island, within a round wall.
    RoundRing,
    /// Rooms in two rows, with doors.
    Rooms,
    /// The same, with doors flush in corners.
    CornerDoors,
    /// Two rooms with a slanted wall between them, which has a door.
    Slanted,
    /// A room with round and square islands, one beside the other.
    Islands,
    /// A room in which three people walk.
    People,
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 12] = [
        Self::Straight,
        Self::Serpentine,
        Self::Zigzag,
        Self::Comb,
        Self::Star,
        Self::Ring,
        Self::RoundRing,
        Self::Rooms,
        Self::CornerDoors,
        Self::Slanted,
        Self::Islands,
        Self::People,
    ];

    /// The name in a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Straight => "straight",
            Self::Serpentine => "serpentine",
            Self::Zigzag => "zigzag",
            Self::Comb => "comb",
            Self::Star => "star",
            Self::Ring => "ring",
            Self::RoundRing => "round-ring",
            Self::Rooms => "rooms",
            Self::CornerDoors => "corner-doors",
            Self::Slanted => "slanted",
            Self::Islands => "islands",
            Self::People => "people",
        }
    }
}

/// A line of walls, or an island.
#[derive(Clone, Debug)]
pub struct Outline {
    /// The points, in metres.
    pub points_m: Vec<[f64; 2]>,
    /// The last point is joined with the first.
    pub is_closed: bool,
    /// The outline is solid.
    pub is_island: bool,
}

/// An arena, and where a robot may begin in it.
#[derive(Clone, Debug)]
pub struct Arena {
    /// Walls and islands.
    pub outlines: Vec<Outline>,
    /// Places with room all around.
    pub starts_m: Vec<[f64; 2]>,
    /// People who walk: where they begin, in metres.
    pub people_m: Vec<[f64; 2]>,
}

/// A run of the table.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The arena's layout.
    pub shape: Shape,
    /// Width of the body, in metres.
    pub body_m: f64,
    /// The width of passages, in widths of the robot.
    pub times: f64,
    /// Chooses the start, and the noise.
    pub seed: u64,
    /// Whether the exploration is by frontiers, and not by nodes.
    pub by_frontiers: bool,
}

/// The course of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Share of what the body can see from where it can be that was sensed.
    pub share: f64,
    /// The number of contacts.
    pub collisions: u64,
    /// The time until the brain published that it is done, or the limit, in seconds.
    pub seconds: f64,
    /// The time since something new was sensed, in seconds.
    pub stale_s: f64,
    /// The longest time for which nothing new was sensed and the brain did not say so, in seconds.
    pub untold_s: f64,
    /// The distance that it drove, in metres.
    pub distance_m: f64,
    /// The last words of the brain.
    pub said: String,
}

impl Case {
    /// The name of the case in a table and in a journal.
    pub fn name(&self) -> String {
        let method = if self.by_frontiers { "frontiers" } else { "nodes" };
        format!("{}/{}/{}/{}/{method}", self.shape.name(), self.body_m, self.times, self.seed)
    }

    /// The case's arena.
    pub fn arena(&self) -> Arena {
        shapes::arena(self.shape, self.body_m * self.times, self.body_m, self.seed)
    }

    /// The case's scenario, as TOML.
    pub fn toml(&self) -> String {
        let arena = self.arena();
        let [x, y] = arena.starts_m[self.seed as usize % arena.starts_m.len()];
        let heading_rad = (self.seed as f64 * 2.4).rem_euclid(6.0) - 3.0;
        let mut toml = head(self.body_m, self.seed);
        for (i, Outline { points_m, is_closed, is_island }) in arena.outlines.iter().enumerate() {
            let line = format!("name='p{i}'\nsolid={is_island}\nclosed={is_closed}\npoints_m={points_m:?}");
            writeln!(toml, "[[arena.polygons]]\n{line}").expect("a text takes all");
        }
        for (i, [x, y]) in arena.people_m.iter().enumerate() {
            let walk = "height_m=1.7\nwander={speed_m_s=0.5, turn_s=4.0}";
            writeln!(toml, "[[arena.movers]]\nname='person_{i}'\nradius_m=0.2\nx_m={x:?}\ny_m={y:?}\n{walk}")
                .expect("a text takes all");
        }
        toml + &robot(self.body_m, [x, y, heading_rad])
    }

    fn scenario(&self) -> Scenario {
        let toml = self.toml();
        baudbot_scenario::parse(&toml).unwrap_or_else(|error| panic!("{}: {error}", self.name()))
    }

    /// Lets `explore` run until it publishes that it is done, at most for so many seconds.
    pub fn run(&self, most_s: f64) -> Outcome {
        let brain = if self.by_frontiers { "explore:method=1" } else { "explore" };
        let scenario = self.scenario();
        let mut local = InProcess::new(scenario, brain).expect("it fits");
        let start = local.world.robot(0).motion().pose.position;
        let (mut said, mut sensed, mut news_s, mut untold_s) = (String::new(), 0.0, 0.0, 0.0_f64);
        let seconds = |local: &InProcess| local.world.time().as_ns() as f64 * 1e-9;
        while seconds(&local) < most_s && !is_over(&said) {
            local.run(100);
            said = local.belief(0).expect("a belief").state;
            let now = local.world.score().sensed(&local.world.scenario().rules).expect("it is counted");
            if now > sensed {
                (sensed, news_s) = (now, seconds(&local));
            }
            if !(is_over(&said) || said.contains("nothing new")) {
                untold_s = untold_s.max(seconds(&local) - news_s);
            }
        }
        let truth = Truth::new(&self.arena(), 0.5 * self.body_m);
        let counters = local.world.robot(0).counters();
        Outcome {
            share: truth.share_sensed(&local.world, [start.x, start.y], RANGE_M),
            collisions: counters.collisions,
            seconds: seconds(&local),
            stale_s: seconds(&local) - news_s,
            untold_s,
            distance_m: counters.distance_m,
            said,
        }
    }
}

impl Outcome {
    /// The fault in it, if there is one.
    pub fn problem(&self) -> Option<&'static str> {
        if self.collisions > 0 {
            return Some("collided");
        }
        if !is_over(&self.said) {
            return Some("does not end");
        }
        if self.share >= ENOUGH {
            return None;
        }
        Some(if self.said == "has seen all" {
            "claims to have seen all"
        } else if self.stale_s > 60.0 {
            "ends late"
        } else {
            "saw too little"
        })
    }
}

fn is_over(said: &str) -> bool {
    said.starts_with("has seen") || said.starts_with("gave up")
}

/// So much of what can be seen is enough.
const ENOUGH: f64 = 0.995;
const RANGE_M: f64 = 4.0;

fn head(body_m: f64, seed: u64) -> String {
    let cell_m = 0.25 * body_m;
    format!(
        "name='narrow'\nseed={seed}\nstep_ms=10.0\nsubsteps=1\ncollision='stop-robot'\n\
         [metrics]\ncell_m={cell_m:?}\nsensed_by='laser'\nsense_ms=200.0\n[end]\nafter_s=3600.0\n"
    )
}

/// The robot of `explore-office`, with all that is part of its body as large as that.
fn robot(body_m: f64, [x, y, heading_rad]: [f64; 3]) -> String {
    let times = body_m / 0.4;
    let mut robot = format!(
        "[[robots]]\nname='robot'\nstart={{x_m={x:?}, y_m={y:?}, heading_rad={heading_rad:?}}}\n\
         [robots.body]\nradius_m={:?}\nheight_m=0.4\nmass_kg=20.0\ninertia_kg_m2={:?}\nwheel_radius_m={:?}\nhalf_track_m={:?}\n\
         [robots.motors]\nkind='velocity'\nfull_speed_m_s=0.8\ngain_n_s=3.75\nmax_torque_nm=5.0\nefficiency=0.6\nsignal_bits=16\n\
         [robots.sensors.encoders]\nkind='encoders'\ncounts_per_turn=1920\nbits=16\nperiod_ms=20.0\n\
         [robots.sensors.odometer]\nkind='odometer'\nperiod_ms=20.0\n\
         [robots.sensors.laser]\npreset='urg-04lx'\nmount={{x_m={:?}}}\nheight_m=0.3\nrange_m={RANGE_M:?}\n",
        0.5 * body_m,
        0.4 * times * times,
        0.075 * times,
        0.17 * times,
        0.05 * times,
    );
    let bearings_rad = [1.309, 0.8727, 0.4363, 0.0, -0.4363, -0.8727, -1.309];
    for (i, bearing_rad) in bearings_rad.into_iter().enumerate() {
        writeln!(
            robot,
            "[robots.sensors.sonar_{i}]\nkind='sonar'\nbearing_rad={bearing_rad:?}\nheight_m=0.05\nopening_rad=0.45\nrays=9\n\
             min_m=0.01\nmax_m=0.6\nperiod_ms=80.0\nphase_ms={:?}",
            1.0 + 11.0 * i as f64
        )
        .expect("a text takes all");
    }
    robot + "[robots.firmware]\nperiod_ms=20.0\nphase_ms=0.5\n[robots.link]\npreset='usb'\n"
}

//! The expected run: the undisturbed one, which is simulated here without a network, tick by tick.

use std::collections::BTreeSet;
use std::ops::AddAssign;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use baudbot_client::{Action, Body, Turn};
use baudbot_proto::v1;
use baudbot_run::LockstepWorld;
use baudbot_server::WorldConfig;
use baudbot_sim::{RobotView, Scenario, World};
use baudbot_tests::{crowd, scenario};

/// The robots' names.
pub(crate) const ROBOTS: [&str; 4] = ["r0", "r1", "r2", "r3"];

/// Ticks of a run.
pub(crate) const TICKS: u64 = 120;

/// The action of all brains: it depends on the Turn only, so a brain that is started again does the same.
pub(crate) fn act(turn: &Turn) -> Action {
    let near = ["ir_left", "ir_front", "ir_right"].map(|name| turn.value(name).unwrap_or(0.0));
    Action::drive(0.5 - 0.4 * near[2] - 0.3 * near[1], 0.5 - 0.4 * near[0])
}

/// The scenario of a run. Frames have numbers, with which a brain that takes another's place begins anew; where brains are lost,
/// commands are bare bytes, so that the newcomer writes what the one before would have written.
pub(crate) fn room(loses_brains: bool) -> Scenario {
    let names = ROBOTS.map(str::to_owned);
    let end = format!("end.after_s={}", TICKS as f64 * 0.01);
    let bare = "={ protocol = \"bare\", mode = \"stream\", period_ms = 20.0 }";
    let bare = ROBOTS.map(|robot| format!("robots.{robot}.firmware{bare}"));
    let mut changes = vec![&*end, "noise=true", "seed=5"];
    changes.extend(bare.iter().filter(|_| loses_brains).map(String::as_str));
    scenario(&crowd(&names), &changes)
}

/// The undisturbed run. Clones are the same.
#[derive(Clone)]
pub(crate) struct Judge(Arc<Known>);

struct Known {
    /// The hashes that the world has at each tick: before its sensors are read, and after that.
    hashes: Vec<BTreeSet<u64>>,
    /// The pose of each robot at each tick.
    places: Vec<Vec<[u64; 3]>>,
    seen: Mutex<Seen>,
    is_forgiven: AtomicBool,
}

/// The number of comparisons.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    pub(crate) statuses: u64,
    pub(crate) frames: u64,
    pub(crate) turns: u64,
}

impl AddAssign for Seen {
    fn add_assign(&mut self, other: Self) {
        self.statuses += other.statuses;
        self.frames += other.frames;
        self.turns += other.turns;
    }
}

impl Judge {
    /// Simulates the run, in the room where brains are lost or in the other one.
    pub(crate) fn new(loses_brains: bool) -> Self {
        let mut world = WorldConfig::new("w", room(loses_brains)).direct().unwrap();
        let bodies: Vec<_> =
            world.world().scenario().robots.iter().map(|spec| Arc::new(Body::from(spec))).collect();
        world.attach("judge", &[0, 1, 2, 3]);
        let (mut hashes, mut places) = (vec![BTreeSet::from([world.world().hash()])], Vec::new());
        loop {
            world.begin();
            let tick = world.world().tick() as usize;
            hashes[tick].insert(world.world().hash());
            places.push(places_in(world.world()));
            for turn in world.turns().to_vec() {
                let action = act(&world.world().turn_of(turn, &bodies[turn.robot]));
                world.act(turn, action).unwrap();
            }
            let goes_on = world.finish();
            hashes.push(BTreeSet::from([world.world().hash()]));
            if !goes_on {
                break;
            }
        }
        // The sensors are read a last time.
        world.begin();
        hashes[world.world().tick() as usize].insert(world.world().hash());
        places.push(places_in(world.world()));
        assert_eq!(hashes.len() as u64, TICKS + 1);
        Self(Arc::new(Known { hashes, places, seen: Mutex::default(), is_forgiven: AtomicBool::new(false) }))
    }

    /// The same run, of which nothing has been seen.
    pub(crate) fn again(&self) -> Self {
        let Known { hashes, places, .. } = &*self.0;
        Self(Arc::new(Known {
            hashes: hashes.clone(),
            places: places.clone(),
            seen: Mutex::default(),
            is_forgiven: AtomicBool::new(false),
        }))
    }

    /// The world is as in the undisturbed run.
    pub(crate) fn check_status(&self, status: &v1::WorldStatus) {
        if self.is_forgiven() {
            return;
        }
        let known = &self.0.hashes[status.tick as usize];
        assert!(
            known.contains(&status.state_hash),
            "at tick {} the world has the hash {:016x} in place of {known:016x?}",
            status.tick,
            status.state_hash
        );
        self.note(|seen| seen.statuses += 1);
    }

    /// The robots are where they are in the undisturbed run.
    pub(crate) fn check_frame(&self, frame: &v1::WatchResponse) {
        if self.is_forgiven() {
            return;
        }
        let places: Vec<_> = frame
            .robots
            .iter()
            .map(|robot| [robot.x_m, robot.y_m, robot.heading_rad].map(f64::to_bits))
            .collect();
        assert_eq!(places, self.0.places[frame.tick as usize], "where the robots are at tick {}", frame.tick);
        self.note(|seen| seen.frames += 1);
    }

    /// A world that had gone ahead of a brain has lost it: from now on it may be another run.
    pub(crate) fn forgive(&self) {
        self.0.is_forgiven.store(true, Ordering::Relaxed);
    }

    pub(crate) fn is_forgiven(&self) -> bool {
        self.0.is_forgiven.load(Ordering::Relaxed)
    }

    pub(crate) fn note_turn(&self) {
        self.note(|seen| seen.turns += 1);
    }

    pub(crate) fn seen(&self) -> Seen {
        *self.0.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn note(&self, change: impl FnOnce(&mut Seen)) {
        change(&mut self.0.seen.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

fn places_in(world: &World) -> Vec<[u64; 3]> {
    let place = |robot: RobotView<'_>| {
        let motion = robot.motion();
        [motion.pose.position.x, motion.pose.position.y, motion.pose.heading].map(f64::to_bits)
    };
    world.robots().map(place).collect()
}

//! Servers that are killed at any instant.
//!
//! Worlds of all kinds live through all rounds, while brains drive and an operator works. The answers before a kill are
//! compared with the state after it: the operator's worlds against worlds in this process with which the same was done,
//! those of brains, at the end, against an undisturbed run.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use baudbot_proto::v1::WorldStatus;
use baudbot_sim::{Intervention, Pose, Scenario, World};
use tonic::Status;

use crate::state::brains::{drive, undisturbed};
use crate::state::operator::{Operator, lockstep, real_time, stepped};
use crate::state::server::Server;
use crate::state::{Chance, WANDER, crowd, parse, place};

const FIRMWARE: &str = "../catalogue/scenarios/firmware.toml";

/// No run ends by a collision.
const ROBOT: &str = "collision=stop-robot";

const ROBOTS: usize = 8;

#[test]
fn worlds_outlive_a_server_that_is_killed() {
    kill(4);
}

#[test]
#[ignore = "takes minutes: ./test kills"]
fn many_kills() {
    let rounds = number("BAUDBOT_KILLS").unwrap_or(50);
    kill(rounds);
    println!("{rounds} of {rounds}");
}

fn number(variable: &str) -> Option<u64> {
    std::env::var(variable).ok()?.parse().ok()
}

fn kill(rounds: u64) {
    let started = Instant::now();
    let seed = number("BAUDBOT_SEED").unwrap_or(0x5EED);
    let folder = place(&format!("kills-{rounds}"));
    let (mut chance, mut worlds) = (Chance(seed), Worlds::default());
    let mut server = Server::start(&folder, &format!("kills-{rounds}"), &[FIRMWARE]);
    worlds.make(&mut server.operator());
    let names: Vec<_> = (0..ROBOTS).map(|i| format!("r{i:02}")).collect();
    let _lines = [
        drive(&server.address, "locked", &["robot"]),
        drive(&server.address, "crowd", &names.iter().map(String::as_str).collect::<Vec<_>>()),
    ];
    for round in 0..rounds {
        let mut operator = server.operator();
        let killer = Killer::after(server, Duration::from_millis(100 + chance.below(700)));
        worlds.work(&mut operator, &mut chance);
        killer.join();
        server = Server::start(&folder, &format!("kills-{rounds}"), &[FIRMWARE]);
        let log = server.log();
        assert!(!log.contains("warning") && !log.contains("ERROR"), "round {round}, seed {seed}: {log}");
        worlds.compare(&mut server.operator(), &format!("round {round}, seed {seed}"));
    }
    let ticks = worlds.end(&mut server.operator());
    println!("{rounds} kills in {:.0} s, {ticks}", started.elapsed().as_secs_f64());
}

/// Kills a server a little later.
struct Killer(std::thread::JoinHandle<()>);

impl Killer {
    fn after(server: Server, wait: Duration) -> Self {
        Self(std::thread::spawn(move || {
            std::thread::sleep(wait);
            server.kill();
        }))
    }

    fn join(self) {
        self.0.join().unwrap();
    }
}

/// The worlds on the server, as far as this process knows.
#[derive(Default)]
struct Worlds {
    /// The worlds that `stepped` and `paused` may be: more than one if a call was not answered.
    stepped: Vec<World>,
    paused: Vec<World>,
    /// Snapshots of `paused`, by their numbers.
    snapshots: Vec<(u64, World)>,
    /// Undisturbed worlds, and the tick at which each was last seen.
    timed: (Option<World>, u64),
    chip: (Option<World>, u64),
    locked: u64,
    crowd: u64,
}

impl Worlds {
    fn make(&mut self, operator: &mut Operator) {
        operator.create("locked", WANDER, (lockstep(), false), &[ROBOT]).unwrap();
        operator.create("crowd", &crowd(ROBOTS), (lockstep(), false), &[]).unwrap();
        operator.create("stepped", WANDER, (stepped(), false), &[ROBOT]).unwrap();
        operator.start("stepped").unwrap();
        operator.create("paused", WANDER, (lockstep(), true), &[ROBOT]).unwrap();
        operator.create("timed", WANDER, (real_time(), false), &[ROBOT, "seed=3"]).unwrap();
        let world = |changes: &[&str]| World::new(parse(WANDER, changes).into());
        self.stepped = vec![world(&[ROBOT])];
        self.paused = vec![world(&[ROBOT])];
        self.timed.0 = Some(world(&[ROBOT, "seed=3"]));
        self.chip.0 = Some(World::new(firmware()));
    }

    /// Works until the server is gone.
    fn work(&mut self, operator: &mut Operator, chance: &mut Chance) {
        while self.work_once(operator, chance).is_ok() {}
    }

    fn work_once(&mut self, operator: &mut Operator, chance: &mut Chance) -> Result<(), Status> {
        let pose = (chance.below(100) as f64 / 100.0 - 0.5, chance.below(100) as f64 / 100.0 - 0.5, 1.0);
        match chance.below(12) {
            0..=4 => self.step(operator, 1 + chance.below(20))?,
            5 => put(&mut self.stepped, operator, "stepped", pose)?,
            6 | 7 => put(&mut self.paused, operator, "paused", pose)?,
            8 => {
                let number = operator.snapshot("paused")?;
                self.snapshots.push((number, self.paused[0].clone()));
            }
            9 if !self.snapshots.is_empty() => {
                // The server keeps 64 of them.
                let recent = self.snapshots.len().min(20) as u64;
                let (number, kept) =
                    &self.snapshots[self.snapshots.len() - 1 - chance.below(recent) as usize];
                self.paused.push(kept.clone());
                told(&mut self.paused, &operator.restore("paused", *number)?);
            }
            _ => {
                self.locked = operator.status("locked")?.tick;
                self.crowd = operator.status("crowd")?.tick;
                self.timed.1 = operator.status("timed")?.tick;
                self.chip.1 = operator.status("firmware")?.tick;
            }
        }
        Ok(())
    }

    fn step(&mut self, operator: &mut Operator, ticks: u64) -> Result<(), Status> {
        let mut world = self.stepped[0].clone();
        for _ in 0..ticks {
            world.begin();
            self.stepped.push(world.clone());
            world.finish(&[]);
            self.stepped.push(world.clone());
        }
        told(&mut self.stepped, &operator.step("stepped", ticks)?);
        Ok(())
    }

    /// Compares the state that is there with the answers.
    fn compare(&mut self, operator: &mut Operator, round: &str) {
        let stepped = operator.status("stepped").unwrap();
        assert!(is_any(&self.stepped, &stepped), "{round}: stepped at {}", stepped.tick);
        told(&mut self.stepped, &stepped);
        let paused = operator.status("paused").unwrap();
        assert!(is_any(&self.paused, &paused), "{round}: paused at {}", paused.tick);
        told(&mut self.paused, &paused);
        for (name, (world, seen)) in [("timed", &mut self.timed), ("firmware", &mut self.chip)] {
            let status = operator.status(name).unwrap();
            assert!(
                status.tick + A_SECOND >= *seen,
                "{round}: {name} was at {seen}, and is at {}",
                status.tick
            );
            let at = reached(world.as_mut().unwrap(), status.tick);
            assert!(at.contains(&status.state_hash), "{round}: {name} at {}", status.tick);
        }
        for (name, seen) in [("locked", self.locked), ("crowd", self.crowd)] {
            let tick = operator.status(name).unwrap().tick;
            assert!(tick >= seen, "{round}: {name} was at {seen}, and is at {tick}");
        }
    }

    /// The worlds of brains are at the end what they would be without all this.
    fn end(&self, operator: &mut Operator) -> String {
        let mut ticks = Vec::new();
        let scenarios = [("locked", parse(WANDER, &[ROBOT])), ("crowd", parse(&crowd(ROBOTS), &[]))];
        for (name, scenario) in scenarios {
            let before = operator.status(name).unwrap().tick;
            // The brain comes back within some seconds.
            operator.wait_until(name, |status| status.tick > before + 100);
            operator.set_pace(name, stepped()).unwrap();
            let mut status = operator.status(name).unwrap();
            loop {
                std::thread::sleep(Duration::from_millis(300));
                let now = operator.status(name).unwrap();
                if (now.tick, now.state_hash) == (status.tick, status.state_hash) {
                    break;
                }
                status = now;
            }
            assert_eq!(status.state_hash, undisturbed(scenario, status.tick), "{name} at {}", status.tick);
            ticks.push(format!("{name} at tick {}", status.tick));
        }
        ticks.join(", ")
    }
}

/// Ticks of 10 ms: so much may be missing of a world that follows the clock.
const A_SECOND: u64 = 100;

fn firmware() -> Arc<Scenario> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(FIRMWARE);
    let toml = std::fs::read_to_string(&path).unwrap();
    let toml = baudbot_import::inline(&toml, path.parent().unwrap()).unwrap();
    baudbot_scenario::parse(&toml).unwrap().into()
}

fn put(
    worlds: &mut Vec<World>,
    operator: &mut Operator,
    name: &str,
    (x, y, heading): (f64, f64, f64),
) -> Result<(), Status> {
    let mut world = worlds[0].clone();
    let placed = Intervention::PlaceRobot { robot: "robot".to_owned(), pose: Pose::new(x, y, heading) };
    let done = world.intervene(&placed);
    worlds.push(world);
    match operator.put(name, (x, y, heading)) {
        Ok(status) => told(worlds, &status),
        // There is no room, here and there.
        Err(status) if status.message().starts_with("intervention: ") => {
            assert!(done.is_err(), "{status:?}");
            worlds.truncate(1);
        }
        Err(status) => return Err(status),
    }
    Ok(())
}

/// The world is this one of those that it may be.
fn told(worlds: &mut Vec<World>, status: &WorldStatus) {
    worlds.retain(|world| is(world, status));
    assert!(
        !worlds.is_empty(),
        "tick {}: {:x} is none of those that it may be",
        status.tick,
        status.state_hash
    );
    worlds.truncate(1);
}

fn is_any(worlds: &[World], status: &WorldStatus) -> bool {
    worlds.iter().any(|world| is(world, status))
}

fn is(world: &World, status: &WorldStatus) -> bool {
    (world.tick(), world.hash()) == (status.tick, status.state_hash)
}

/// The fingerprints of an undisturbed world at this tick, before and after the tick has begun.
fn reached(world: &mut World, tick: u64) -> [u64; 2] {
    if world.tick() > tick {
        *world = World::new(Arc::clone(world.origin()));
    }
    while world.tick() < tick {
        world.begin();
        world.finish(&[]);
    }
    let mut begun = world.clone();
    begun.begin();
    [world.hash(), begun.hash()]
}

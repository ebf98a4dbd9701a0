//! The answers that an operator got, and the state that a server which starts again may therefore have.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::time::Duration;

use baudbot_proto::v1;

/// The time that the power has to be on until an answer's effect is there after it fails: files are forced onto the
/// disk once a second.
const ON_DISK_AFTER: Duration = Duration::from_millis(2500);

/// The time after a fault of the disk until the state is kept again.
const KEPT_AFTER: Duration = Duration::from_millis(4500);

/// The time of an answer about a state that is on the disk.
const EVER: Duration = Duration::ZERO;

/// A time later than anything.
const FAR: Duration = Duration::from_secs(1 << 40);

/// All worlds that there have been, by name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Model {
    pub(crate) worlds: BTreeMap<String, World>,
    /// The times between which the disk did not take everything.
    faults: Vec<(Duration, Duration)>,
    /// Fingerprints that were found and were in no answer: maybe within a tick, where no Step ends.
    untold: BTreeSet<u64>,
    /// The servers that there have been.
    lives: Vec<Life>,
    /// The number of ended worlds at the last comparison.
    compared: usize,
}

/// The begin and the end of a server, and how it ended.
#[derive(Clone, Copy, Debug)]
struct Life {
    began: Duration,
    died: Duration,
    end: End,
}

/// A world by the answers about it.
#[derive(Clone, Debug, Default)]
pub(crate) struct World {
    /// The states that it had: the time of the answer, the tick and the fingerprint.
    states: Vec<(Duration, u64, u64)>,
    pub(crate) snapshots: BTreeMap<u64, Snapshot>,
    /// The time of the answer that it is gone.
    gone: Option<Duration>,
    /// The world may be gone, as that request got no answer.
    may_be_gone: bool,
    /// The last request got no answer: the world may have gone so many ticks further.
    unsure_ticks: u64,
    /// The world may have any state that it had.
    is_unsure: bool,
}

/// A snapshot by the answers about it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Snapshot {
    told: Duration,
    tick: u64,
    hash: u64,
    /// A server has ended before it was certain.
    may_be_lost: bool,
    /// A server was killed while the disk failed to take it, which the next one cannot know: it reads what was not written.
    is_doubtful: bool,
}

/// The kind of a server's end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    Killed,
    PowerLost,
}

impl Model {
    /// The disk did not take everything from then until then.
    pub(crate) fn fault(&mut self, from: Duration, until: Duration) {
        self.faults.push((from, until));
    }

    /// The disk does not take everything from now on.
    pub(crate) fn fault_begins(&mut self, now: Duration) {
        self.faults.push((now, FAR));
    }

    /// The disk takes everything again.
    pub(crate) fn fault_ends(&mut self, now: Duration) {
        self.faults.iter_mut().filter(|(_, until)| *until == FAR).for_each(|(_, until)| *until = now);
    }

    /// A server has ended.
    pub(crate) fn ended(&mut self, began: Duration, died: Duration, end: End) {
        self.lives.push(Life { began, died, end });
    }

    /// The servers that have ended since the last comparison.
    fn ends(&self) -> &[Life] {
        &self.lives[self.compared..]
    }

    /// Whether a server has ended.
    pub(crate) fn has_ended(&self) -> bool {
        !self.lives.is_empty()
    }

    /// Whether the power has failed since the last comparison.
    pub(crate) fn has_lost_power(&self) -> bool {
        self.ends().iter().any(|life| life.end == End::PowerLost)
    }

    /// The time by which an answer of this time has been kept for so long without a fault.
    fn after(&self, told: Duration, long: Duration) -> Duration {
        let mut from = told;
        let overlaps = |from: Duration| {
            let mut faults = self.faults.iter();
            faults.find(|(begins, ends)| *begins <= from + long && from < *ends + KEPT_AFTER)
        };
        while let Some((_, ends)) = overlaps(from) {
            from = *ends + KEPT_AFTER;
        }
        from + long
    }

    /// Whether the state of an answer of this time is there, whatever has ended since the last comparison. It is forced
    /// onto the disk by a server that lives long enough.
    fn is_certain(&self, told: Duration) -> bool {
        let is_on_disk = |lives: &[Life]| {
            let forces = |life: &Life| self.after(told.max(life.began), ON_DISK_AFTER) <= life.died;
            lives.iter().any(forces)
        };
        let survives = |(place, life): (usize, &Life)| match life.end {
            End::Killed => self.after(told, Duration::ZERO) <= life.died,
            End::PowerLost => is_on_disk(&self.lives[..=place]),
        };
        told == EVER || self.lives.iter().enumerate().skip(self.compared).all(survives)
    }

    /// Whether a server has ended while the disk failed to take the state of an answer of this time.
    fn is_doubtful(&self, told: Duration) -> bool {
        self.ends().iter().any(|life| {
            let from = told.max(life.began);
            let mut faults = self.faults.iter();
            let fails = faults.any(|(begins, ends)| *begins <= life.died && from < *ends + KEPT_AFTER);
            from <= life.died && fails && self.after(from, ON_DISK_AFTER) > life.died
        })
    }

    /// Whether the disk did not take everything at this time, or what it had not taken was not kept again yet.
    fn is_faulty(&self, at: Duration) -> bool {
        self.faults.iter().any(|(from, until)| (*from..*until + KEPT_AFTER).contains(&at))
    }

    /// Checks what a server has that has started again at `now`, and notes it; those before have ended so. Gives the worlds that stand
    /// within a Step of which it is known where it leads.
    pub(crate) fn check(&mut self, found: &BTreeMap<String, v1::WorldStatus>, now: Duration) -> Vec<Within> {
        let mut within = Vec::new();
        for name in found.keys() {
            assert!(self.worlds.contains_key(name), "`{name}` was never there");
        }
        let names: Vec<_> = self.worlds.keys().cloned().collect();
        for name in names {
            let world = &self.worlds[&name];
            match (found.get(&name), world.gone) {
                // If the disk has failed meanwhile, it may come back.
                (None, Some(gone)) if self.is_faulty(gone) => {}
                (None, Some(_)) => drop(self.worlds.remove(&name)),
                (None, None) => {
                    let made = world.states.first().map_or(FAR, |(told, ..)| *told);
                    assert!(
                        world.may_be_gone || !self.is_certain(made),
                        "`{name}` was there at {made:?} and is not after {:?}",
                        self.ends()
                    );
                    self.worlds.remove(&name);
                }
                (Some(_), Some(gone)) => {
                    assert!(
                        self.is_faulty(gone),
                        "`{name}` was deleted at {gone:?} and is there again after {:?}",
                        self.ends()
                    );
                    self.worlds.get_mut(&name).unwrap().gone = None;
                }
                (Some(status), None) => within.extend(self.check_state(&name, status)),
            }
        }
        self.restarted(found, now);
        within
    }

    /// The possible states of a server that starts again, in words.
    pub(crate) fn expected(&self) -> String {
        let mut text = String::new();
        for (name, world) in &self.worlds {
            let rest = &world.states[self.certain(world)..];
            let states = rest.iter().map(|(told, tick, hash)| {
                format!(" tick {tick} with {hash:016x} (told at {:.3})", told.as_secs_f64())
            });
            let states: String = states.collect();
            let World { gone, may_be_gone, unsure_ticks, is_unsure, .. } = world;
            let _ = writeln!(
                text,
                "             `{name}`:{states} or between; gone {gone:?}, may be gone {may_be_gone}, ticks more {unsure_ticks}, any state {is_unsure}"
            );
        }
        let _ =
            write!(text, "             servers: {:?}\n             faults: {:?}", self.ends(), self.faults);
        text
    }

    /// The last state of a world that is certain.
    fn certain(&self, world: &World) -> usize {
        world.states.iter().rposition(|(told, ..)| self.is_certain(*told)).unwrap_or(0)
    }

    fn check_state(&self, name: &str, status: &v1::WorldStatus) -> Option<Within> {
        let world = &self.worlds[name];
        if world.is_unsure {
            return None;
        }
        let rest = &world.states[self.certain(world)..];
        let tick = status.tick;
        if rest.iter().any(|state| (state.1, state.2) == (tick, status.state_hash)) {
            return None;
        }
        let last = rest.last().map_or(0, |state| state.1);
        if world.unsure_ticks > 0 && (last..=last + world.unsure_ticks).contains(&tick) {
            return None;
        }
        // Within a Step each tick is kept, and that it has begun.
        let mut within = rest.windows(2).filter(|pair| (pair[0].1..pair[1].1).contains(&tick));
        if let Some(pair) = within.next() {
            // The answers after a Restore may be several, and it is not known which holds.
            if self.untold.contains(&pair[1].2) {
                return None;
            }
            let leads_to = Within { world: name.to_owned(), ticks: pair[1].1 - tick, hash: pair[1].2 };
            return within.next().is_none().then_some(leads_to);
        }
        panic!(
            "`{name}` is at tick {tick} with {:016x} after {:?}; it was told {:?}, the last {} of which are not certain, and may be {} ticks further",
            status.state_hash,
            self.ends(),
            world.states,
            rest.len() - 1,
            world.unsure_ticks
        )
    }

    /// Uncertain changes may be lost. After a power cut all that is there is there for good.
    fn restarted(&mut self, found: &BTreeMap<String, v1::WorldStatus>, now: Duration) {
        let loses_power = self.has_lost_power();
        let mut worlds = std::mem::take(&mut self.worlds);
        for snapshot in worlds.values_mut().flat_map(|world| world.snapshots.values_mut()) {
            snapshot.may_be_lost |= !self.is_certain(snapshot.told);
            snapshot.is_doubtful |= self.is_doubtful(snapshot.told);
        }
        self.worlds = worlds;
        for status in found.values() {
            let states = &self.worlds[&status.world].states;
            if states.iter().all(|state| state.2 != status.state_hash) {
                self.untold.insert(status.state_hash);
            }
            if loses_power {
                self.worlds.get_mut(&status.world).expect("it is known").states.clear();
            }
            self.told(status, if loses_power { EVER } else { now });
        }
        self.compared = self.lives.len();
    }

    /// Notes an answer with the status of a world.
    pub(crate) fn told(&mut self, status: &v1::WorldStatus, now: Duration) {
        let world = self.worlds.get_mut(&status.world).expect("a world that was made");
        world.states.push((now, status.tick, status.state_hash));
        (world.unsure_ticks, world.is_unsure, world.may_be_gone) = (0, false, false);
    }

    /// Whether a world can be made of this name. One that was deleted while the disk failed may come back.
    pub(crate) fn is_free(&self, name: &str, now: Duration) -> bool {
        let world = self.worlds.get(name);
        world.is_none_or(|world| world.gone.is_some_and(|gone| !self.is_faulty(gone) && !self.is_faulty(now)))
    }

    /// A world is going to be made.
    pub(crate) fn create(&mut self, name: &str) {
        let world = World { may_be_gone: true, is_unsure: true, ..World::default() };
        self.worlds.insert(name.to_owned(), world);
    }

    pub(crate) fn snapshot(&mut self, number: u64, status: &v1::WorldStatus, now: Duration) {
        self.told(status, now);
        let world = self.worlds.get_mut(&status.world).unwrap();
        let (tick, hash) = (status.tick, status.state_hash);
        world
            .snapshots
            .insert(number, Snapshot { told: now, tick, hash, may_be_lost: false, is_doubtful: false });
    }

    /// A snapshot may have been made, with the number of one that is lost.
    pub(crate) fn may_have_snapshot(&mut self, world: &str) {
        let world = self.worlds.get_mut(world).unwrap();
        world.snapshots.retain(|_, snapshot| !snapshot.may_be_lost);
    }

    /// Checks a restored snapshot.
    pub(crate) fn restored(&mut self, number: u64, status: &v1::WorldStatus, now: Duration) {
        let world = self.worlds.get_mut(&status.world).unwrap();
        let Snapshot { tick, hash, may_be_lost, .. } = world.snapshots.get_mut(&number).unwrap();
        let name = &status.world;
        assert_eq!((status.tick, status.state_hash), (*tick, *hash), "snapshot {number} of `{name}`");
        *may_be_lost = false;
        self.told(status, now);
    }

    /// A snapshot is not there. That is wrong, unless a server has ended before it was certain.
    pub(crate) fn no_snapshot(&mut self, world: &str, number: u64) {
        let snapshots = &mut self.worlds.get_mut(world).unwrap().snapshots;
        let snapshot = snapshots.remove(&number).unwrap();
        assert!(
            snapshot.may_be_lost || snapshot.is_doubtful,
            "snapshot {number} of `{world}` is lost: {snapshot:?}"
        );
    }

    pub(crate) fn deleted(&mut self, world: &str, now: Duration) {
        let world = self.worlds.get_mut(world).unwrap();
        world.gone = Some(now);
    }

    pub(crate) fn there(&self) -> Vec<String> {
        let there = self.worlds.iter().filter(|(_, world)| world.gone.is_none());
        there.map(|(name, _)| name.clone()).collect()
    }

    /// Notes a request that got no answer.
    pub(crate) fn unsure(&mut self, world: &str, deed: Unsure) {
        let world = self.worlds.get_mut(world).expect("a world that was made");
        match deed {
            Unsure::Ticks(ticks) => world.unsure_ticks = ticks,
            Unsure::Gone => world.may_be_gone = true,
            Unsure::Any => world.is_unsure = true,
        }
    }

    /// Notes the answer that a world does not exist.
    pub(crate) fn is_gone(&mut self, world: &str) {
        let there = &self.worlds[world];
        assert!(there.gone.is_some() || there.may_be_gone, "`{world}` is gone");
        self.worlds.remove(world);
    }
}

/// A possible effect of a request.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Unsure {
    Ticks(u64),
    Gone,
    Any,
}

/// A world that stands within a Step: after so many ticks it has this fingerprint.
#[derive(Debug)]
pub(crate) struct Within {
    pub(crate) world: String,
    pub(crate) ticks: u64,
    pub(crate) hash: u64,
}

//! An observer's view of the pins of a robot's chip.

use std::collections::BTreeSet;

use baudbot_sim::chip::{Board, News, Scope, Shown};
use baudbot_sim::{SimTime, World};

/// Events on a robot's pins that a frame has at most: the last ones.
const MOST_EVENTS: usize = 8192;

/// An observer's knowledge of the pins of a robot's chip.
pub(super) struct Pins {
    finest_ns: u64,
    scope: Scope,
    /// The events for the next frame.
    waiting: Vec<(usize, Shown)>,
    missed: u64,
}

impl Pins {
    /// The pins of a robot, if it has a chip. Pulses with a shorter period are summed up.
    pub(super) fn new(robot: usize, finest_ns: u64, world: &World) -> Option<Self> {
        let chip = world.scenario().robots.get(robot)?.chip.as_ref()?;
        Some(Self { finest_ns, scope: Scope::new(chip, finest_ns), waiting: Vec::new(), missed: 0 })
    }

    /// Forgets what the observer knows.
    pub(super) fn reset(&mut self, robot: usize, world: &World) {
        if let Some(anew) = Self::new(robot, self.finest_ns, world) {
            *self = anew;
        }
    }

    /// Takes in the new edges.
    pub(super) fn look(&mut self, robot: usize, world: &World) {
        let view = world.robot(robot);
        let Some(board) = view.board() else { return };
        let News { lost, shown } = self.scope.look(board, world.time().as_ns());
        self.missed += lost;
        self.waiting.extend(shown);
        let gone = self.waiting.len().saturating_sub(MOST_EVENTS);
        if gone > 0 {
            self.missed += gone as u64;
            self.drop_oldest(gone);
        }
    }

    /// The events until an instant, and the number of those that are left out. A chip may be ahead of it, and later
    /// events wait.
    pub(super) fn take(&mut self, at: SimTime) -> (Vec<(usize, Shown)>, u64) {
        let is_past = |(_, shown): &(usize, Shown)| shown.at_ns() <= at.as_ns();
        let (told, later) = std::mem::take(&mut self.waiting).into_iter().partition(is_past);
        self.waiting = later;
        (told, std::mem::take(&mut self.missed))
    }

    /// Drops the oldest events, but for the last of signals without a later one: it still holds.
    fn drop_oldest(&mut self, gone: usize) {
        let later = self.waiting.split_off(gone);
        let mut told: BTreeSet<usize> = later.iter().map(|(signal, _)| *signal).collect();
        let dropped = std::mem::replace(&mut self.waiting, later);
        let last: Vec<_> = dropped.into_iter().rev().filter(|(signal, _)| told.insert(*signal)).collect();
        self.waiting.splice(0..0, last.into_iter().rev());
    }
}

/// The robots whose edges a world keeps for its observers.
#[derive(Default)]
pub(super) struct Kept(BTreeSet<usize>);

impl Kept {
    /// The world keeps the edges of these robots, and no longer those of others, unless they are wanted elsewhere.
    pub(super) fn fit(&mut self, wanted: &BTreeSet<usize>, world: &mut World) {
        if self.0.is_empty() && wanted.is_empty() {
            return;
        }
        for &robot in wanted {
            let is_kept = world.robot(robot).board().and_then(Board::edges).is_some();
            if !is_kept {
                world.keep_edges(robot, true);
                self.0.insert(robot);
            }
        }
        let robots = world.robots().len();
        self.0.retain(|robot| {
            let stays = wanted.contains(robot);
            if !stays && *robot < robots {
                world.keep_edges(*robot, false);
            }
            stays
        });
    }
}

//! Watchers of one world's cables: each gets the bytes of one cable with their meaning. A slow watcher misses items and
//! never slows the world, and a cable without watchers costs nothing.

use std::collections::{BTreeSet, VecDeque};

use baudbot_proto::v1;
use baudbot_sim::World;
use baudbot_sim::cable::Listener;
use baudbot_wire::meaning::Item;
use prost::Message as _;

use crate::convert;
use crate::limits::{Outbox, Parts};
use crate::message::WatchCable;

/// Items that wait for a watcher that does not read. Of more the oldest are missed.
const MOST_WAITING: usize = 512;

/// Bytes of each direction of a cable that a world keeps between two looks.
const MOST_KEPT: usize = 1 << 16;

/// The most bytes of an item for a watcher.
const MOST_TOLD: usize = 4096;

/// The watchers of a world's cables.
#[derive(Default)]
pub(crate) struct Cables {
    present: Vec<Watcher>,
    /// The robots whose bytes the world keeps for them.
    taped: BTreeSet<usize>,
}

struct Watcher {
    robot: usize,
    listener: Listener,
    news: Outbox,
    waiting: VecDeque<v1::CableItem>,
    missed: u64,
    /// The number of bytes that the world did not keep, and that the watcher knows of.
    missed_bytes: u64,
    has_restarted: bool,
}

impl Cables {
    /// Adds a watcher, which gets a first message at once. The watch of a cable that does not exist ends at once.
    pub(crate) fn add(&mut self, watch: WatchCable, world: &mut World) {
        let WatchCable { robot, cable, news } = watch;
        let listener = world.scenario().robots.get(robot).and_then(|spec| Listener::new(spec, cable));
        let Some(listener) = listener else { return };
        if push(&news, &v1::WatchCableResponse::default()) {
            let (waiting, missed, missed_bytes, has_restarted) = (VecDeque::new(), 0, 0, false);
            self.present.push(Watcher {
                robot,
                listener,
                news,
                waiting,
                missed,
                missed_bytes,
                has_restarted,
            });
            self.keep_tapes(world);
            // Bytes that came before are left out.
            self.present.last_mut().into_iter().for_each(|watcher| watcher.catch_up(world));
        }
    }

    /// Whether there are no watchers.
    pub(crate) fn is_empty(&self) -> bool {
        self.present.is_empty()
    }

    /// Sends watchers what has come since the last time.
    pub(crate) fn listen(&mut self, world: &mut World) {
        if self.present.is_empty() {
            return;
        }
        let before = self.present.len();
        self.present.retain_mut(|watcher| watcher.listen(world));
        if self.present.len() < before {
            self.keep_tapes(world);
        }
    }

    /// Drops the state of the analysis: the world is at another time.
    pub(crate) fn reset(&mut self, world: &mut World) {
        self.keep_tapes(world);
        for watcher in &mut self.present {
            watcher.listener.reset(world.robot(watcher.robot).spec());
            watcher.missed_bytes = 0;
            watcher.has_restarted = true;
            watcher.catch_up(world);
        }
    }

    /// The world keeps the bytes of robots whose cables are watched, and of no others.
    fn keep_tapes(&mut self, world: &mut World) {
        let robots = world.robots().len();
        for robot in 0..robots {
            let is_watched = self.present.iter().any(|watcher| watcher.robot == robot);
            if is_watched && !world.keeps_tape(robot) {
                world.keep_tape(robot, MOST_KEPT);
                self.taped.insert(robot);
            } else if !is_watched && self.taped.remove(&robot) {
                world.keep_tape(robot, 0);
            }
        }
    }
}

impl Watcher {
    /// Bytes that have come by now are left out.
    fn catch_up(&mut self, world: &World) {
        self.listener.look(&world.robot(self.robot), world.time(), &mut |_: Item<'_>, _| {});
        self.missed_bytes = self.listener.missed_bytes();
    }

    /// Sends what is new, if there is room; `false` if the watcher is gone.
    fn listen(&mut self, world: &World) -> bool {
        let Self { listener, waiting, missed, .. } = self;
        listener.look(&world.robot(self.robot), world.time(), &mut |item: Item<'_>, _| {
            if waiting.len() == MOST_WAITING {
                waiting.pop_front();
                *missed += 1;
            }
            waiting.push_back(convert::cable_item(&item, MOST_TOLD));
        });
        // Bytes that the world did not keep are at least one item.
        if listener.missed_bytes() > self.missed_bytes {
            self.missed_bytes = listener.missed_bytes();
            self.missed += 1;
        }
        if self.waiting.is_empty() && !self.has_restarted {
            return !self.news.is_closed();
        }
        if self.news.places() == 0 || !self.news.has_budget() {
            return !self.news.is_closed();
        }
        let items = self.waiting.drain(..).collect();
        let restarted = std::mem::take(&mut self.has_restarted);
        push(&self.news, &v1::WatchCableResponse { items, missed_items: self.missed, restarted })
    }
}

/// Sends these news; `false` if the watcher is gone.
fn push(to: &Outbox, news: &v1::WatchCableResponse) -> bool {
    to.push(Parts(vec![news.encode_to_vec().into()]))
}

#[cfg(test)]
mod tests {
    use baudbot_sim::Input;
    use baudbot_sim::cable::Cable;
    use futures_util::{FutureExt as _, StreamExt as _};

    use super::*;
    use crate::limits::{Account, InForce, Inbox, Limits};

    fn outbox(places: usize) -> (Outbox, Inbox) {
        let limits = InForce::new(Limits::none());
        limits.outbox(&limits.tally(&Account::Process), "WatchCable", places)
    }

    /// The news that are there.
    fn told(inbox: &mut Inbox) -> Option<v1::WatchCableResponse> {
        Some(inbox.next().now_or_never()??.unwrap().decode().unwrap())
    }

    /// A Khepera on a cable that takes no time: each tick is a question and an answer.
    fn khepera() -> World {
        let toml = "[[robots]]\nname = \"k\"\npreset = \"khepera-1\"\nlink = { kind = \"ideal\" }\n\
                    firmware = { protocol = \"khepera\" }\n";
        World::new(baudbot_scenario::parse(toml).unwrap_or_else(|error| panic!("{error}")).into())
    }

    fn ask(world: &mut World, cables: &mut Cables, ticks: usize) {
        for _ in 0..ticks {
            let turns = world.begin().to_vec();
            let input = |turn: &baudbot_sim::Turn| Input { robot: 0, at: turn.at, bytes: b"N\r" };
            world.finish(&turns.iter().map(input).collect::<Vec<_>>());
            cables.listen(world);
        }
    }

    #[test]
    fn a_watcher_that_does_not_read_misses_the_oldest_items_and_is_told_how_many() {
        let (mut world, mut cables) = (khepera(), Cables::default());
        let (news, mut inbox) = outbox(1);
        cables.add(WatchCable { robot: 0, cable: Cable::Robot, news }, &mut world);
        ask(&mut world, &mut cables, 1000);
        assert!(told(&mut inbox).unwrap().items.is_empty(), "the first news are that it watches");
        ask(&mut world, &mut cables, 1);
        let news = told(&mut inbox).unwrap();
        assert_eq!(news.items.len(), MOST_WAITING);
        assert!((1000..2000).contains(&news.missed_items), "{}", news.missed_items);
        assert!(news.items.is_sorted_by_key(|item| item.to_ns));
        ask(&mut world, &mut cables, 1);
        let next = told(&mut inbox).unwrap();
        assert!(!next.items.is_empty() && next.missed_items == news.missed_items, "{next:?}");
    }

    #[test]
    fn bytes_are_kept_only_while_somebody_watches() {
        let (mut world, mut cables) = (khepera(), Cables::default());
        assert!(!world.keeps_tape(0));
        let (news, inbox) = outbox(8);
        cables.add(WatchCable { robot: 0, cable: Cable::Robot, news }, &mut world);
        assert!(world.keeps_tape(0) && !cables.is_empty());
        drop(inbox);
        ask(&mut world, &mut cables, 1);
        assert!(!world.keeps_tape(0) && cables.is_empty());
        // A watcher of a cable that does not exist gets nothing.
        let (news, mut inbox) = outbox(8);
        cables.add(WatchCable { robot: 0, cable: Cable::Sensor(0), news }, &mut world);
        assert!(cables.is_empty() && told(&mut inbox).is_none());
    }
}

//! Beliefs: what brains publish for people to see. Only the newest belief of each robot's brain is kept.
//!
//! Beliefs do not pass through the world. Brains write here from their streams, observers read when a frame is made for them;
//! so a brain that publishes without end costs the world nothing.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use baudbot_proto::v1;
use prost::Message as _;

/// The beliefs of a world's brains. Clones share them.
#[derive(Clone)]
pub(crate) struct Beliefs(Arc<Mutex<Board>>);

struct Board {
    /// Beliefs that have been published so far.
    published: u64,
    robots: Vec<Place>,
    /// The size of all beliefs that are kept, in bytes of the wire.
    bytes: usize,
}

/// A robot's place on the board.
#[derive(Default)]
struct Place {
    /// The session that may write here.
    holder: Option<u64>,
    newest: Option<Newest>,
}

struct Newest {
    /// The belief's number among all that were published, from 1.
    number: u64,
    belief: Arc<v1::Belief>,
    bytes: usize,
}

impl Beliefs {
    pub(crate) fn new(robots: usize) -> Self {
        let robots = std::iter::repeat_with(Place::default).take(robots).collect();
        Self(Arc::new(Mutex::new(Board { published: 0, robots, bytes: 0 })))
    }

    /// Lets only this session's brain publish for the robots from now on, and forgets what was published for them.
    pub(crate) fn hand_to(&self, holder: Option<u64>, robots: &[usize]) {
        let mut board = self.lock();
        for &robot in robots {
            board.forget(robot);
            board.robots[robot].holder = holder;
        }
    }

    /// Forgets all beliefs: the world is at another time.
    pub(crate) fn forget_all(&self) {
        let mut board = self.lock();
        (0..board.robots.len()).for_each(|robot| board.forget(robot));
    }

    /// Publishes a belief for a robot, if the session still holds the robot.
    pub(crate) fn publish(&self, holder: u64, robot: usize, belief: v1::Belief) {
        let mut board = self.lock();
        if board.robots.get(robot).is_some_and(|place| place.holder == Some(holder)) {
            board.put(robot, belief);
        }
    }

    /// The beliefs that have been published since number `seen`, with their robots: the oldest first, and not more than a frame
    /// has room for. `seen` is then the number of the newest of these.
    pub(crate) fn since(&self, seen: &mut u64) -> Vec<(usize, Arc<v1::Belief>)> {
        let board = self.lock();
        if board.published <= *seen {
            return Vec::new();
        }
        let places = board.robots.iter().enumerate();
        let newest = places.filter_map(|(robot, place)| Some((robot, place.newest.as_ref()?)));
        let mut news: Vec<_> = newest.filter(|(_, newest)| newest.number > *seen).collect();
        news.sort_unstable_by_key(|(_, newest)| newest.number);
        let mut bytes = 0;
        let fits = |(_, newest): &(usize, &Newest)| {
            bytes += newest.bytes;
            bytes <= MAX_FRAME_BYTES
        };
        let told: Vec<_> = news.into_iter().take_while(fits).collect();
        *seen = told.last().map_or(board.published, |(_, newest)| newest.number);
        told.into_iter().map(|(robot, newest)| (robot, Arc::clone(&newest.belief))).collect()
    }

    /// The number of beliefs that have been published so far.
    pub(crate) fn published(&self) -> u64 {
        self.lock().published
    }

    /// The state that each robot's brain has published last, in words; empty if it has published none.
    pub(crate) fn said(&self) -> Vec<String> {
        let said = |place: &Place| {
            let state = place.newest.as_ref().map_or("", |newest| &newest.belief.state);
            state.chars().take(MAX_SAID).collect()
        };
        self.lock().robots.iter().map(said).collect()
    }

    fn lock(&self) -> MutexGuard<'_, Board> {
        // The board is consistent between any two of its changes.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Board {
    fn put(&mut self, robot: usize, belief: v1::Belief) {
        self.published += 1;
        let bytes = belief.encoded_len();
        let newest = Newest { number: self.published, belief: Arc::new(belief), bytes };
        let before = self.robots[robot].newest.replace(newest);
        self.bytes = self.bytes + bytes - before.map_or(0, |before| before.bytes);
        // If many brains publish maps, the oldest beliefs are forgotten.
        while self.bytes > MAX_BOARD_BYTES {
            let heavy =
                self.robots.iter_mut().filter_map(|place| place.newest.as_mut()).filter(|n| n.bytes > 0);
            let Some(oldest) = heavy.min_by_key(|newest| newest.number) else { return };
            self.bytes -= std::mem::take(&mut oldest.bytes);
            oldest.belief = Arc::default();
        }
    }

    /// Forgets a robot's belief, so that observers get an empty one.
    fn forget(&mut self, robot: usize) {
        if self.robots[robot].newest.as_ref().is_some_and(|newest| newest.bytes > 0) {
            self.put(robot, v1::Belief::default());
        }
    }
}

/// Bytes of the longest belief.
pub(crate) const MAX_BYTES: usize = 256 << 10;

/// Characters of a brain's state that its robot's status has.
const MAX_SAID: usize = 256;

/// Bytes of beliefs that one frame has room for.
const MAX_FRAME_BYTES: usize = 1 << 20;

/// Bytes of beliefs that a world keeps.
const MAX_BOARD_BYTES: usize = 64 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    fn belief(state: &str) -> v1::Belief {
        v1::Belief { state: state.to_owned(), ..v1::Belief::default() }
    }

    /// A board on which session 1 holds the robots.
    fn board(robots: usize) -> Beliefs {
        let beliefs = Beliefs::new(robots);
        beliefs.hand_to(Some(1), &(0..robots).collect::<Vec<_>>());
        beliefs
    }

    #[test]
    fn an_observer_gets_the_newest_of_each_robot_once() {
        let beliefs = board(2);
        let mut seen = 0;
        assert!(beliefs.since(&mut seen).is_empty());
        for state in ["a", "b"] {
            beliefs.publish(1, 1, belief(state));
        }
        beliefs.publish(1, 0, belief("c"));
        beliefs.publish(1, 7, belief("no such robot"));
        beliefs.publish(2, 0, belief("somebody else"));
        let told = beliefs.since(&mut seen);
        let told: Vec<_> = told.iter().map(|(robot, belief)| (*robot, belief.state.as_str())).collect();
        assert_eq!(told, [(1, "b"), (0, "c")]);
        assert_eq!(beliefs.said(), ["c", "b"]);
        assert!(beliefs.since(&mut seen).is_empty());
        assert_eq!(beliefs.since(&mut 2).len(), 1);
        beliefs.publish(1, 0, belief(&"ä".repeat(300)));
        assert_eq!(beliefs.said()[0], "ä".repeat(256));
    }

    #[test]
    fn what_a_brain_said_goes_with_it_and_observers_learn_that() {
        let (beliefs, mut seen) = (board(1), 0);
        beliefs.publish(1, 0, belief("here"));
        beliefs.since(&mut seen);
        beliefs.hand_to(Some(2), &[0]);
        assert_eq!(*beliefs.since(&mut seen)[0].1, v1::Belief::default());
        beliefs.publish(1, 0, belief("a ghost"));
        assert!(beliefs.since(&mut seen).is_empty());
        beliefs.publish(2, 0, belief("successor"));
        beliefs.forget_all();
        assert_eq!(*beliefs.since(&mut seen)[0].1, v1::Belief::default());
    }

    #[test]
    fn a_crowd_with_maps_neither_fills_the_memory_nor_a_frame() {
        let (beliefs, mut seen) = (board(1000), 0);
        for robot in 0..1000 {
            beliefs.publish(1, robot, belief(&"m".repeat(200 << 10)));
        }
        assert!(beliefs.lock().bytes <= MAX_BOARD_BYTES);
        let mut told = Vec::new();
        loop {
            let frame = beliefs.since(&mut seen);
            if frame.is_empty() {
                break;
            }
            assert!(frame.iter().map(|(_, belief)| belief.encoded_len()).sum::<usize>() <= MAX_FRAME_BYTES);
            told.extend(frame.into_iter().map(|(robot, _)| robot));
        }
        assert_eq!(told, (0..1000).collect::<Vec<_>>());
    }
}

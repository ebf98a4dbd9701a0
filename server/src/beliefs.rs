//! What brains publish for people to see: the newest word of each robot's brain, and nothing of before.
//!
//! It passes the world by. Brains write here from their streams, observers read when a frame is made for them; so a
//! brain that publishes without end costs the world nothing.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use baudbot_proto::v1;

/// What the brains of a world believe. Clones share it.
#[derive(Clone)]
pub(crate) struct Beliefs(Arc<Mutex<Board>>);

struct Board {
    /// How often somebody has published something.
    published: u64,
    /// By robot, each with its number among all that were published.
    newest: Vec<Option<(u64, Arc<v1::Belief>)>>,
}

impl Beliefs {
    pub(crate) fn new(robots: usize) -> Self {
        Self(Arc::new(Mutex::new(Board { published: 0, newest: vec![None; robots] })))
    }

    /// A robot's brain publishes this.
    pub(crate) fn publish(&self, robot: usize, belief: v1::Belief) {
        let mut board = self.lock();
        board.published += 1;
        let number = board.published;
        if let Some(place) = board.newest.get_mut(robot) {
            *place = Some((number, Arc::new(belief)));
        }
    }

    /// What has been published since number `seen`, by robot; `seen` is then the number of the newest.
    pub(crate) fn since(&self, seen: &mut u64) -> Vec<(usize, Arc<v1::Belief>)> {
        let board = self.lock();
        let before = std::mem::replace(seen, board.published);
        let newest = board.newest.iter().enumerate().filter(|_| board.published > before);
        newest
            .filter_map(|(robot, newest)| Some((robot, newest.as_ref()?)))
            .filter(|(_, (number, _))| *number > before)
            .map(|(robot, (_, belief))| (robot, Arc::clone(belief)))
            .collect()
    }

    fn lock(&self) -> MutexGuard<'_, Board> {
        // The board is sound between any two of its calls.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Bytes of the longest belief.
pub(crate) const MAX_BYTES: usize = 256 << 10;

#[cfg(test)]
mod tests {
    use super::*;

    fn belief(state: &str) -> v1::Belief {
        v1::Belief { state: state.to_owned(), ..v1::Belief::default() }
    }

    #[test]
    fn an_observer_gets_the_newest_of_each_robot_once() {
        let beliefs = Beliefs::new(2);
        let mut seen = 0;
        assert!(beliefs.since(&mut seen).is_empty());
        for state in ["a", "b"] {
            beliefs.publish(1, belief(state));
        }
        beliefs.publish(0, belief("c"));
        beliefs.publish(7, belief("nobody"));
        let told = beliefs.since(&mut seen);
        let told: Vec<_> = told.iter().map(|(robot, belief)| (*robot, belief.state.as_str())).collect();
        assert_eq!(told, [(0, "c"), (1, "b")]);
        assert!(beliefs.since(&mut seen).is_empty());
        assert_eq!(beliefs.since(&mut 2).len(), 1);
    }
}

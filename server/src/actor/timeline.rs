//! The robots' timelines: how much of them a world on a server keeps.

use super::WorldActor;

/// Events of each robot that a world without observers keeps: enough for the first picture of one that comes. Of a
/// thousand worlds with a robot each, all that a world keeps by itself would be a tenth of a gigabyte.
const UNSEEN_EVENTS: usize = 512;

impl WorldActor {
    /// Keeps as many events as usual if there is an observer, and fewer otherwise.
    pub(super) fn fit_timeline(&mut self) {
        let usual = self.world.usual_timeline();
        let is_seen = self.on_tick.is_some()
            || self.replaying.is_some()
            || self.observers.have_details()
            || self.recording.has_frames();
        let events = if is_seen { usual } else { usual.min(UNSEEN_EVENTS) };
        self.world.resize_timeline(events);
        self.charges.fit_timeline(events, &self.world);
    }
}

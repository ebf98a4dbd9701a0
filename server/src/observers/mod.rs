//! Observers of one world. A slow observer misses frames and never slows the world.

mod details;
mod pins;

use std::cell::OnceCell;
use std::collections::BTreeSet;
use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_sim::World;
use baudbot_sim::collision::Collision;
use baudbot_sim::raycast::RayCaster;
use bytes::Bytes;
use prost::Message as _;

use crate::beliefs::Beliefs;
use crate::convert;
use crate::limits::{Outbox, Parts};
use crate::log::event;
use crate::message::Watch;
use crate::sessions::Sessions;
use details::Detailed;
pub(crate) use details::MAX_DETAILS;
use pins::Kept;

/// Collisions that are kept for an observer between two of its frames; a crowd in a heap makes no more.
const MAX_COLLISIONS: usize = 1000;

/// The observers of a world.
#[derive(Default)]
pub(crate) struct Observers {
    present: Vec<Observer>,
    /// The number of the last observer that came.
    last_number: u64,
    /// Frames that were missed by observers that are gone.
    missed_frames: u64,
    kept: Kept,
}

struct Observer {
    number: u64,
    every_ticks: u64,
    frames: Outbox,
    missed_frames: u64,
    /// Whether it has missed the last frame that was due.
    misses: bool,
    eye: Eye,
}

/// Makes the frames of one observer: it knows what the observer has seen already.
pub(crate) struct Eye {
    collisions: Vec<Collision>,
    detailed: Vec<Detailed>,
    /// The number of the last belief that it has seen.
    published: u64,
}

/// The observers' part of a world.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    /// The world's name.
    pub(crate) name: &'a str,
    pub(crate) world: &'a World,
    pub(crate) sessions: &'a Sessions,
    pub(crate) beliefs: &'a Beliefs,
}

/// The parts that are made once for all observers of the world in this state.
struct Shared<'a> {
    view: View<'a>,
    /// The part of a frame that is the same for all, in bytes.
    truth: OnceCell<Bytes>,
    caster: OnceCell<RayCaster<'a>>,
}

impl<'a> Shared<'a> {
    fn new(view: View<'a>) -> Self {
        Self { view, truth: OnceCell::new(), caster: OnceCell::new() }
    }

    fn truth(&self) -> Bytes {
        self.truth.get_or_init(|| convert::truth(self.view.world).encode_to_vec().into()).clone()
    }
}

impl Observers {
    /// Adds an observer. It gets a first frame at once, also of a world that stands.
    pub(crate) fn add(&mut self, watch: Watch, view: View<'_>) {
        self.each(view, |_| true);
        self.last_number += 1;
        let Watch { every_ticks, details, pins_finest_ns, frames } = watch;
        let mut observer = Observer {
            number: self.last_number,
            every_ticks: every_ticks.max(1),
            frames,
            missed_frames: 0,
            misses: false,
            eye: Eye::new(details, pins_finest_ns, view.world),
        };
        if observer.show(&Shared::new(view)) {
            event!(
                view,
                info,
                observer = observer.number,
                every_ticks = observer.every_ticks,
                "observer joined"
            );
            self.present.push(observer);
        }
    }

    /// The world keeps the signals of the pins of robots for their observers, the one that is about to come among them.
    pub(crate) fn keep_pins(&mut self, coming: Option<&Watch>, world: &mut World) {
        let mut wanted = self.pinned();
        let coming = coming.filter(|watch| watch.pins_finest_ns.is_some());
        wanted.extend(coming.into_iter().flat_map(|watch| &watch.details));
        let robots = &world.scenario().robots;
        wanted.retain(|robot| robots.get(*robot).is_some_and(|spec| spec.chip.is_some()));
        self.kept.fit(&wanted, world);
    }

    /// The robots whose pins have an observer.
    pub(crate) fn pinned(&self) -> BTreeSet<usize> {
        let present = self.present.iter().filter(|observer| !observer.frames.is_closed());
        present.flat_map(|observer| observer.eye.detailed.iter().filter_map(Detailed::pinned)).collect()
    }

    /// Whether there are no observers.
    pub(crate) fn is_empty(&self) -> bool {
        self.present.is_empty()
    }

    /// Whether an observer gets details of a robot.
    pub(crate) fn have_details(&self) -> bool {
        self.present.iter().any(|observer| !observer.eye.detailed.is_empty())
    }

    /// The number of connected observers.
    pub(crate) fn count(&self) -> usize {
        self.present.iter().filter(|observer| !observer.frames.is_closed()).count()
    }

    /// Frames that observers have missed, those that are gone included.
    pub(crate) fn missed_frames(&self) -> u64 {
        self.missed_frames + self.present.iter().map(|observer| observer.missed_frames).sum::<u64>()
    }

    /// Sends a frame at the start of a tick to the observers that are due for one; at the end of a run, to all. The tick has
    /// not begun, or it is [kept](World::keep_starts) how robots were then: cables are ahead of bodies within a tick.
    pub(crate) fn show(&mut self, view: View<'_>) {
        let shared = Shared::new(view);
        self.each(view, |observer| {
            let world = view.world;
            observer.eye.note(world);
            let due = world.tick().is_multiple_of(observer.every_ticks) || world.ending().is_some();
            !due || observer.show(&shared)
        });
    }

    /// Collects the data of a tick of which no frame is sent.
    pub(crate) fn note(&mut self, world: &World) {
        self.present.iter_mut().for_each(|observer| observer.eye.note(world));
    }

    /// Forgets what observers have seen: the world is at another time.
    pub(crate) fn reset(&mut self, world: &mut World) {
        self.keep_pins(None, world);
        self.present.iter_mut().for_each(|observer| observer.eye.reset(world));
    }

    /// Sends all observers a frame between two ticks: the world was changed by hand, or is at another tick.
    pub(crate) fn show_now(&mut self, view: View<'_>) {
        let shared = Shared::new(view);
        self.each(view, |observer| observer.show(&shared));
    }

    /// Calls `see` for all observers, and removes those for which it is `false` or that are gone.
    fn each(&mut self, view: View<'_>, mut see: impl FnMut(&mut Observer) -> bool) {
        self.present.retain_mut(|observer| {
            let stays = !observer.frames.is_closed() && see(observer);
            if !stays {
                let missed_frames = observer.missed_frames;
                self.missed_frames += missed_frames;
                event!(view, info, observer = observer.number, missed_frames, "observer gone");
            }
            stays
        });
    }
}

impl Observer {
    /// Sends a frame if there is room; `false` if the observer is gone.
    fn show(&mut self, shared: &Shared<'_>) -> bool {
        let view = shared.view;
        let world = view.world;
        // The last place is for the end of the run, which no observer must miss.
        let has_room = match world.ending() {
            Some(_) => self.frames.places() >= 1,
            None => self.frames.places() >= 2 && self.frames.has_budget(),
        };
        if !has_room {
            self.missed_frames += 1;
            if !std::mem::replace(&mut self.misses, true) {
                event!(view, debug, observer = self.number, "observer does not read, and misses frames");
            }
            return !self.frames.is_closed();
        }
        if std::mem::take(&mut self.misses) {
            let missed_frames = self.missed_frames;
            event!(view, debug, observer = self.number, missed_frames, "observer reads again");
        }
        let own = self.eye.own(shared, self.missed_frames).encode_to_vec().into();
        self.frames.push(Parts(vec![shared.truth(), own]))
    }
}

impl Eye {
    /// An eye that has details of these robots, and of their pins if pulses with a shorter period are summed up.
    fn new(details: impl IntoIterator<Item = usize>, pins_finest_ns: Option<u64>, world: &World) -> Self {
        let detailed = |robot| Detailed::new(robot, pins_finest_ns, world);
        let detailed = details.into_iter().map(detailed).collect();
        Self { collisions: Vec::new(), detailed, published: 0 }
    }

    /// An eye that has details of all robots, or of as many as it may.
    pub(crate) fn of_all(world: &World) -> Self {
        Self::new(0..world.robots().len().min(MAX_DETAILS), None, world)
    }

    /// Collects, before each tick, the data of past ticks for the next frame.
    pub(crate) fn note(&mut self, world: &World) {
        let room = MAX_COLLISIONS.saturating_sub(self.collisions.len());
        self.collisions.extend(world.collisions().iter().take(room).cloned());
        self.detailed.iter_mut().for_each(|detailed| detailed.note(world));
    }

    fn reset(&mut self, world: &World) {
        self.detailed.iter_mut().for_each(|detailed| detailed.reset(world));
    }

    /// A frame of the world as it stands.
    pub(crate) fn frame(&mut self, view: View<'_>) -> v1::WatchResponse {
        let v1::WatchResponse { collisions, missed_frames, details, annotations, .. } =
            self.own(&Shared::new(view), 0);
        v1::WatchResponse { collisions, missed_frames, details, annotations, ..convert::truth(view.world) }
    }

    /// The part of a frame that is this observer's only. Behind the bytes of the other part it makes a whole frame.
    fn own(&mut self, shared: &Shared<'_>, missed_frames: u64) -> v1::WatchResponse {
        let collision = |Collision { robot, with }| v1::Collision { robot, with };
        let annotation = |(robot, belief): (usize, Arc<v1::Belief>)| v1::Annotation {
            robot: robot as u32,
            belief: Some(Arc::unwrap_or_clone(belief)),
        };
        let beliefs = shared.view.beliefs.since(&mut self.published);
        v1::WatchResponse {
            collisions: std::mem::take(&mut self.collisions).into_iter().map(collision).collect(),
            missed_frames,
            details: self.details(shared),
            annotations: beliefs.into_iter().map(annotation).collect(),
            ..Default::default()
        }
    }

    fn details(&mut self, shared: &Shared<'_>) -> Vec<v1::RobotDetail> {
        if self.detailed.is_empty() {
            return Vec::new();
        }
        let view = shared.view;
        let caster = shared.caster.get_or_init(|| RayCaster::new(view.world));
        let detailed = self.detailed.iter_mut();
        detailed.map(|detailed| detailed.tell(view.world, view.sessions, caster)).collect()
    }
}

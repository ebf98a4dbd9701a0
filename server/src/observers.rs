//! Observers of one world. A slow one misses frames and never slows the world.

use baudbot_sim::collision::Collision;
use baudbot_sim::sight::Onlooker;
use baudbot_sim::{RobotView, ThingView, World};
use tokio::sync::mpsc;

use crate::beliefs::Beliefs;
use crate::details::{Detail, Detailed, MAX_DETAILS};
use crate::letter::{Charge, Frame, Score, Thing, Truth, Watch};
use crate::log::event;
use crate::sessions::Sessions;

/// Collisions that are kept for an observer between two of its frames; a crowd in a heap makes no more.
const MAX_COLLISIONS: usize = 1000;

#[derive(Default)]
pub(crate) struct Observers {
    here: Vec<Observer>,
    /// How many have come.
    came: u64,
    /// Frames missed by those that are gone.
    missed_frames: u64,
}

struct Observer {
    number: u64,
    every_ticks: u64,
    frames: mpsc::Sender<Frame>,
    missed_frames: u64,
    /// It missed the last one.
    misses: bool,
    eye: Eye,
}

/// Looks at a world, and knows what it has seen.
pub(crate) struct Eye {
    collisions: Vec<Collision>,
    detailed: Vec<Detailed>,
    /// What brains published that it has seen.
    published: u64,
}

/// What observers can see of a world.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    /// The world's name.
    pub(crate) name: &'a str,
    pub(crate) world: &'a World,
    pub(crate) sessions: &'a Sessions,
    pub(crate) beliefs: &'a Beliefs,
}

impl Observers {
    /// A new observer, who gets a first frame at once, also of a world that stands.
    pub(crate) fn add(&mut self, watch: Watch, view: View<'_>) {
        self.each(view, |_| true);
        self.came += 1;
        let Watch { every_ticks, details, frames } = watch;
        let mut observer = Observer {
            number: self.came,
            every_ticks: every_ticks.max(1),
            frames,
            missed_frames: 0,
            misses: false,
            eye: Eye::new(details, view.world),
        };
        if observer.show(view) {
            event!(
                view,
                info,
                observer = observer.number,
                every_ticks = observer.every_ticks,
                "observer joined"
            );
            self.here.push(observer);
        }
    }

    /// Whether nobody looks.
    pub(crate) fn is_empty(&self) -> bool {
        self.here.is_empty()
    }

    /// How many look.
    pub(crate) fn count(&self) -> usize {
        self.here.iter().filter(|observer| !observer.frames.is_closed()).count()
    }

    /// Frames that were missed by any, also by those that are gone.
    pub(crate) fn missed_frames(&self) -> u64 {
        self.missed_frames + self.here.iter().map(|observer| observer.missed_frames).sum::<u64>()
    }

    /// Sends the truth at the start of a tick to those whose turn it is; at the end of a run, to all.
    pub(crate) fn show(&mut self, view: View<'_>) {
        self.each(view, |observer| {
            let world = view.world;
            observer.eye.note(world);
            let due = world.tick().is_multiple_of(observer.every_ticks) || world.ending().is_some();
            !due || observer.show(view)
        });
    }

    /// The world is at another time: what observers were told of is over.
    pub(crate) fn begin_anew(&mut self, world: &World) {
        self.here.iter_mut().for_each(|observer| observer.eye.begin_anew(world));
    }

    /// Sends everybody the truth between two ticks: something has been changed by hand.
    pub(crate) fn show_now(&mut self, view: View<'_>) {
        self.each(view, |observer| observer.show(view));
    }

    /// Sees to all that are there, and lets those go of whom it is `false`.
    fn each(&mut self, view: View<'_>, mut see: impl FnMut(&mut Observer) -> bool) {
        self.here.retain_mut(|observer| {
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
    /// `false` if the observer is gone.
    fn show(&mut self, view: View<'_>) -> bool {
        let world = view.world;
        // The last place is for the end of the run, which no observer must miss.
        let needed = if world.ending().is_some() { 1 } else { 2 };
        if self.frames.capacity() < needed {
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
        let frame = Frame { missed_frames: self.missed_frames, ..self.eye.frame(view) };
        self.frames.try_send(frame).is_ok()
    }
}

impl Eye {
    /// One that looks more closely at some robots.
    fn new(details: impl IntoIterator<Item = usize>, world: &World) -> Self {
        let detailed = details.into_iter().map(|robot| Detailed::new(robot, world)).collect();
        Self { collisions: Vec::new(), detailed, published: 0 }
    }

    /// One that looks closely at all robots, or as many as one may.
    pub(crate) fn of_all(world: &World) -> Self {
        Self::new(0..world.robots().len().min(MAX_DETAILS), world)
    }

    /// At the start of each tick: what is told in the next frame though it is of this tick.
    pub(crate) fn note(&mut self, world: &World) {
        let room = MAX_COLLISIONS.saturating_sub(self.collisions.len());
        self.collisions.extend(world.collisions().iter().take(room).cloned());
        self.detailed.iter_mut().for_each(|detailed| detailed.note(world));
    }

    fn begin_anew(&mut self, world: &World) {
        self.detailed.iter_mut().for_each(|detailed| detailed.begin_anew(world));
    }

    /// What it sees now.
    pub(crate) fn frame(&mut self, view: View<'_>) -> Frame {
        let world = view.world;
        Frame {
            tick: world.tick(),
            time: world.time(),
            robots: world.robots().enumerate().map(|(i, robot)| truth(world, i, &robot)).collect(),
            collisions: std::mem::take(&mut self.collisions),
            missed_frames: 0,
            ending: world.ending().map(ToString::to_string),
            things: world.things().map(thing).collect(),
            score: Score::of(world),
            details: self.details(view),
            beliefs: view.beliefs.since(&mut self.published),
        }
    }

    fn details(&mut self, view: View<'_>) -> Vec<Detail> {
        if self.detailed.is_empty() {
            return Vec::new();
        }
        let onlooker = Onlooker::new(view.world);
        let detailed = self.detailed.iter_mut();
        detailed.map(|detailed| detailed.tell(view.world, view.sessions, &onlooker)).collect()
    }
}

fn thing(view: ThingView<'_>) -> Thing {
    let (position, heading_rad) = (view.pose.position, view.pose.heading);
    let name = view.name.to_owned();
    Thing { name, x_m: position.x, y_m: position.y, heading_rad, blocked_ns: view.blocked_ns }
}

fn truth(world: &World, index: usize, robot: &RobotView<'_>) -> Truth {
    let mut samples = Vec::new();
    for (sensor, spec) in robot.sensors().zip(robot.spec().sensors.iter()) {
        let missing = spec.encodings.len() - sensor.sample.len();
        samples.extend(sensor.sample.iter().copied().chain(std::iter::repeat_n(f64::NAN, missing)));
    }
    Truth {
        motion: *robot.motion(),
        signals: robot.signals(),
        collided: robot.collided(),
        samples,
        actuators: robot.actuators().to_vec(),
        battery: Charge::of(robot),
        in_zone_ns: world.score().in_zone_ns(index).to_vec(),
    }
}

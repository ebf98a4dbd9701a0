//! A run that is watched tick by tick: on a server of its own, which its brains attach to, or, with programs in simulated time, on a
//! thread.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use baudbot_proto::v1;
use baudbot_run::assignment::Assigned;
use baudbot_run::in_process::drivers;
use baudbot_run::simulation::{Simulation, TickError, tick};
use baudbot_run::{BareWorld, DrivenWorld};
use baudbot_server::{Lockstep, Pace, WorldConfig};
use baudbot_sim::{Scenario, World};
use tokio::sync::oneshot;
use tokio::sync::oneshot::error::TryRecvError;

use crate::error::Error;
use crate::private_server::PrivateServer;
use crate::remote::{Host, Remote};
use crate::setup::Setup;

/// A run that is under way, in lockstep. It is given up when this is dropped: then its programs end, too.
pub struct Served<T> {
    seen: Option<Receiver<T>>,
    stop: Option<oneshot::Sender<()>>,
    run: Option<JoinHandle<Result<(), Error>>>,
}

/// The next result of a run.
pub enum Next<T> {
    /// The view of the next tick.
    Seen(T),
    /// The run is over, or is given up because it is to stop.
    Over,
    /// Nothing has come in time.
    Late,
}

/// The pose that a brain believes its robot to have, as it has published it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Believed {
    /// The place of its robot.
    pub robot: usize,
    /// In metres.
    pub x_m: f64,
    /// In metres.
    pub y_m: f64,
}

impl<T: Send + 'static> Served<T> {
    /// Starts a run of a world at its start, with brains of the catalogue and programs. What `look` makes of the world at the beginning
    /// of each tick, and at the run's end, is what [`next`](Self::next) gives; the world is at most a few ticks ahead of it. `look` also gets
    /// the poses that brains have published since the tick before.
    ///
    /// # Errors
    /// If no server can be started.
    pub fn start(
        world: World,
        assigned: Assigned,
        mut look: impl FnMut(&World, &[Believed]) -> T + Send + 'static,
    ) -> Result<Self, Error> {
        let (send, seen) = sync_channel(AHEAD);
        let (stop, stopped) = oneshot::channel();
        let thread = std::thread::Builder::new().name("run".to_owned());
        let no_thread = |error| Error::Server(format!("cannot start a thread: {error}"));
        if !assigned.at_ports.is_empty() {
            let each = move |world: &World| send.send(look(world, &[])).is_ok();
            let run = thread.spawn(move || in_simulated_time(world, &assigned, stopped, each));
            return Ok(Self { seen: Some(seen), stop: Some(stop), run: Some(run.map_err(no_thread)?) });
        }
        let believed = Arc::new(Mutex::new(Vec::new()));
        let told = Arc::clone(&believed);
        let on_belief = Box::new(move |_: &World, robot, belief: &v1::Belief| {
            let pose = belief.pose.as_ref().map(|pose| Believed { robot, x_m: pose.x_m, y_m: pose.y_m });
            told.lock().unwrap_or_else(PoisonError::into_inner).extend(pose);
        });
        let on_tick = Box::new(move |world: &World| {
            // The receiver of a run that is given up has gone.
            let believed = std::mem::take(&mut *believed.lock().unwrap_or_else(PoisonError::into_inner));
            let _ = send.send(look(world, &believed));
        });
        let scenario = Scenario::clone(world.scenario());
        let world = WorldConfig::from_state(WORLD, world).pace(Pace::Lockstep(Lockstep::default()));
        let server = PrivateServer::start([world.paused(true).on_belief(on_belief).on_tick(on_tick)])?;
        let run = thread.spawn(move || {
            let remote = Remote::connect(Host::Private(&server), WORLD, None)?;
            remote.run_world(WORLD, Setup { scenario, assigned }, stopped)
        });
        Ok(Self { seen: Some(seen), stop: Some(stop), run: Some(run.map_err(no_thread)?) })
    }

    /// The view of the next tick; `None` once the run is over, or is given up because `stop` is set.
    ///
    /// # Errors
    /// If a brain has failed, or the server.
    pub fn next(&mut self, stop: &AtomicBool) -> Result<Option<T>, Error> {
        loop {
            match self.next_within(FOR_EVER, stop)? {
                Next::Seen(seen) => return Ok(Some(seen)),
                Next::Over => return Ok(None),
                Next::Late => {}
            }
        }
    }

    /// The view of the next tick, if it comes within `patience` by the wall clock.
    ///
    /// # Errors
    /// If a brain has failed, or the server.
    pub fn next_within(&mut self, patience: Duration, stop: &AtomicBool) -> Result<Next<T>, Error> {
        let begun = Instant::now();
        while let Some(seen) = &self.seen
            && !stop.load(Ordering::Relaxed)
        {
            match seen.recv_timeout(LOOK.min(patience)) {
                Ok(next) => return Ok(Next::Seen(next)),
                Err(RecvTimeoutError::Timeout) if begun.elapsed() >= patience => return Ok(Next::Late),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        self.end()?;
        Ok(Next::Over)
    }
}

/// A run with programs at ports, to the end of the world, until `stop`, or as long as somebody looks. A program that has ended leaves its
/// robot as it is.
fn in_simulated_time(
    world: World,
    assigned: &Assigned,
    mut stop: oneshot::Receiver<()>,
    mut each: impl FnMut(&World) -> bool,
) -> Result<(), Error> {
    let refused = |error: &dyn std::fmt::Display| Error::Refused(error.to_string());
    let seed = world.scenario().seed;
    let drivers =
        drivers(&world.scenario().robots, &assigned.brains, seed).map_err(|error| refused(&error))?;
    let mut driven = DrivenWorld { world: BareWorld::new(world), drivers };
    let mut programs =
        Simulation::start(&mut driven.world, &assigned.at_ports, seed).map_err(|error| refused(&error))?;
    let mut is_looked_at = true;
    while driven.world.ending().is_none() {
        if !is_looked_at || stop.try_recv() != Err(TryRecvError::Empty) {
            return Ok(());
        }
        let ticked = tick(&mut driven, &mut programs, |driven| {
            is_looked_at = each(&driven.world);
            Ok(())
        });
        if let Err(TickError::Program(error)) = ticked {
            return Err(refused(&error));
        }
    }
    driven.world.begin();
    each(&driven.world);
    Ok(())
}

impl<T> Served<T> {
    /// The world may be waiting for room, and the run's programs end before this program does.
    fn end(&mut self) -> Result<(), Error> {
        self.seen = None;
        self.stop = None;
        let Some(run) = self.run.take() else { return Ok(()) };
        let panicked = || Err(Error::Server("the run panicked, which is a bug in baudbot".to_owned()));
        run.join().unwrap_or_else(|_| panicked())
    }
}

impl<T> Drop for Served<T> {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

/// The interval at which the stop is checked.
const LOOK: Duration = Duration::from_millis(50);

/// Longer than any run.
const FOR_EVER: Duration = Duration::from_secs(u32::MAX as u64);

const WORLD: &str = "run";

/// The number of ticks that the world may be ahead of its observer.
const AHEAD: usize = 16;

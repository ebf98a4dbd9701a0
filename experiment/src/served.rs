//! A run on a server of its own, which its brains attach to, and which is watched tick by tick.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use baudbot_server::{Lockstep, Pace, WorldConfig};
use baudbot_sim::{Scenario, World};
use tokio::sync::oneshot;

use crate::assignment::Assigned;
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

impl<T: Send + 'static> Served<T> {
    /// Starts a run of a world at its start, with brains of the catalogue and programs. What `look` makes of the world at the beginning
    /// of each tick, and at the run's end, is what [`next`](Self::next) gives; the world is at most a few ticks ahead of it.
    ///
    /// # Errors
    /// If no server can be started.
    pub fn start(
        world: World,
        assigned: Assigned,
        mut look: impl FnMut(&World) -> T + Send + 'static,
    ) -> Result<Self, Error> {
        let (send, seen) = sync_channel(AHEAD);
        let (stop, stopped) = oneshot::channel();
        let on_tick = Box::new(move |world: &World| {
            // Nobody watches a run that is given up.
            let _ = send.send(look(world));
        });
        let scenario = Scenario::clone(world.scenario());
        let world = WorldConfig::from_state(WORLD, world).pace(Pace::Lockstep(Lockstep::default()));
        let server = PrivateServer::start([world.paused(true).on_tick(on_tick)])?;
        let run = std::thread::Builder::new().name("run".to_owned()).spawn(move || {
            let remote = Remote::connect(Host::Private(&server), WORLD)?;
            remote.run_world(WORLD, Setup { scenario, assigned }, stopped)
        });
        let run = run.map_err(|error| Error::Server(format!("cannot start a thread: {error}")))?;
        Ok(Self { seen: Some(seen), stop: Some(stop), run: Some(run) })
    }

    /// What was seen of the next tick; `None` once the run is over, or is given up because `stop` is set.
    ///
    /// # Errors
    /// If a brain has failed, or the server.
    pub fn next(&mut self, stop: &AtomicBool) -> Result<Option<T>, Error> {
        while let Some(seen) = &self.seen
            && !stop.load(Ordering::Relaxed)
        {
            match seen.recv_timeout(LOOK) {
                Ok(next) => return Ok(Some(next)),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        self.end()?;
        Ok(None)
    }

    fn end(&mut self) -> Result<(), Error> {
        // The world may be waiting for room.
        self.seen = None;
        self.stop = None;
        let Some(run) = self.run.take() else { return Ok(()) };
        run.join()
            .unwrap_or_else(|_| Err(Error::Server("the run panicked, which is a bug in baudbot".to_owned())))
    }
}

impl<T> Drop for Served<T> {
    fn drop(&mut self) {
        self.seen = None;
        self.stop = None;
        if let Some(run) = self.run.take() {
            // Its programs end before this program does.
            let _ = run.join();
        }
    }
}

/// How often is looked whether the run is to be given up.
const LOOK: Duration = Duration::from_millis(50);

const WORLD: &str = "run";

/// So many ticks the world may be ahead of who watches it.
const AHEAD: usize = 16;

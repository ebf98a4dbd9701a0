//! The threads of a state folder: one writes for worlds that follow a clock, the other forces onto the disk what was written.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::files::WorldFiles;

/// The interval at which writes are forced onto the disk.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// The alarm of the threads. They end when all of these are gone.
#[derive(Clone, Debug)]
pub(super) enum Threads {
    Own {
        writer: Sender<Arc<WorldFiles>>,
        syncer: Sender<Arc<WorldFiles>>,
    },
    /// Tasks of the writer's runtime do the work.
    Tasks,
}

impl Threads {
    /// Starts the threads.
    ///
    /// # Errors
    /// If there are none.
    pub(super) fn start() -> io::Result<Self> {
        let (writer, to_write) = channel::<Arc<WorldFiles>>();
        let (syncer, to_sync) = channel();
        thread::Builder::new().name("state".to_owned()).spawn(move || {
            for files in to_write {
                files.write();
            }
        })?;
        thread::Builder::new().name("state sync".to_owned()).spawn(move || sync_all(&to_sync))?;
        Ok(Self::Own { writer, syncer })
    }

    /// There is something to write of this world.
    pub(super) fn write(&self, files: &Arc<WorldFiles>) {
        let files = Arc::clone(files);
        match self {
            // The threads live as long as this does.
            Self::Own { writer, .. } => drop(writer.send(files)),
            Self::Tasks => drop(tokio::spawn(async move { files.write() })),
        }
    }

    /// Something was written of this world.
    pub(super) fn sync(&self, files: &Arc<WorldFiles>) {
        let files = Arc::clone(files);
        match self {
            Self::Own { syncer, .. } => drop(syncer.send(files)),
            Self::Tasks => drop(tokio::spawn(async move {
                tokio::time::sleep(SYNC_EVERY).await;
                files.sync();
            })),
        }
    }
}

fn sync_all(written: &Receiver<Arc<WorldFiles>>) {
    let mut waiting = Vec::new();
    let mut next = Instant::now() + SYNC_EVERY;
    loop {
        match written.recv_timeout(next.saturating_duration_since(Instant::now())) {
            Ok(files) => waiting.push(files),
            Err(RecvTimeoutError::Timeout) => {
                waiting.drain(..).for_each(|files| files.sync());
                next = Instant::now() + SYNC_EVERY;
            }
            Err(RecvTimeoutError::Disconnected) => return waiting.drain(..).for_each(|files| files.sync()),
        }
    }
}

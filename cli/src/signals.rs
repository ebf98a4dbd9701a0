//! Ctrl-C and SIGTERM.

use std::sync::mpsc;
use std::{io, process, thread};

use tokio::runtime;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;

/// The wish of a person or a system that the program ends.
///
/// A thread of its own hears the signals, as a file or a pipe may block all others: the first signal is
/// passed on, so that all ends in good order, and the second ends the program at once.
pub(crate) struct Stop(watch::Receiver<bool>);

impl Stop {
    /// From now on a single signal does not kill the program.
    pub(crate) fn listen() -> io::Result<Self> {
        let (stop, stopped) = watch::channel(false);
        let (ready, readiness) = mpsc::channel();
        let hear = move || match runtime::Builder::new_current_thread().enable_all().build() {
            Ok(runtime) => runtime.block_on(hear(&stop, &ready)),
            Err(error) => drop(ready.send(Err(error))),
        };
        thread::Builder::new().name("signals".to_owned()).spawn(hear)?;
        readiness.recv().map_err(io::Error::other)??;
        Ok(Self(stopped))
    }

    /// Whether there has been a signal.
    pub(crate) fn is_wanted(&self) -> bool {
        *self.0.borrow()
    }

    /// Waits for the first signal; returns at once if it has been there.
    pub(crate) async fn wait(&mut self) {
        if self.0.wait_for(|stop| *stop).await.is_err() {
            // Nobody hears signals any more.
            std::future::pending::<()>().await;
        }
    }
}

async fn hear(stop: &watch::Sender<bool>, ready: &mpsc::Sender<io::Result<()>>) {
    let signals = signal(SignalKind::interrupt()).and_then(|int| Ok((int, signal(SignalKind::terminate())?)));
    let (mut interrupt, mut terminate) = match signals {
        Ok(signals) => signals,
        Err(error) => return drop(ready.send(Err(error))),
    };
    let _ = ready.send(Ok(()));
    loop {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
        if stop.send_replace(true) {
            process::exit(INTERRUPTED.into());
        }
    }
}

/// The exit code of what was ended by Ctrl-C, as shells have it.
pub(crate) const INTERRUPTED: u8 = 130;

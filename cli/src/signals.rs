//! Ctrl-C, SIGTERM, and the terminal that is closed.

use std::sync::mpsc;
use std::time::Duration;
use std::{io, process, thread};

use tokio::runtime;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio::sync::watch;

use crate::load::Load;
use crate::text::tell;

/// The wish of a person or a system that the program ends.
///
/// A thread of its own receives the signals, as a file or a pipe may block all others: the first signal is passed on,
/// so that all ends in good order, and the second Ctrl-C or SIGTERM ends the program at once.
pub(crate) struct Stop(watch::Receiver<bool>);

impl Stop {
    /// A single signal no longer kills the program from now on.
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

    /// A function that returns whether there has been a signal, for other threads.
    pub(crate) fn flag(&self) -> impl Fn() -> bool + Send + Sync + use<> {
        let stopped = self.0.clone();
        move || *stopped.borrow()
    }

    /// Ends the program so long after the first signal, if it has not ended by itself: all other threads may be waiting
    /// for a disk. `words` makes the error's text of the reason.
    pub(crate) fn exit_after(
        &self,
        limit: Duration,
        words: impl FnOnce(&str) -> String + Send + 'static,
    ) -> io::Result<()> {
        let mut stopped = self.0.clone();
        let runtime = runtime::Builder::new_current_thread().build()?;
        let wait = move || {
            if runtime.block_on(stopped.wait_for(|stop| *stop)).is_ok() {
                let load = Load::begin();
                thread::sleep(limit);
                tell!("error: {}", words(&load.cause()));
                process::exit(1);
            }
        };
        thread::Builder::new().name("last resort".to_owned()).spawn(wait).map(drop)
    }

    /// Waits for the first signal; returns at once if it has been there.
    pub(crate) async fn wait(&mut self) {
        if self.0.wait_for(|stop| *stop).await.is_err() {
            // The sender of signals is gone, so none will come.
            std::future::pending::<()>().await;
        }
    }
}

async fn hear(stop: &watch::Sender<bool>, ready: &mpsc::Sender<io::Result<()>>) {
    let signals = signal(SignalKind::interrupt()).and_then(|interrupt| {
        let hangup = (!ignores_hangup()).then(|| signal(SignalKind::hangup())).transpose()?;
        Ok((interrupt, signal(SignalKind::terminate())?, hangup))
    });
    let (mut interrupt, mut terminate, mut hangup) = match signals {
        Ok(signals) => signals,
        Err(error) => return drop(ready.send(Err(error))),
    };
    let _ = ready.send(Ok(()));
    let mut is_asked = false;
    loop {
        let asks = tokio::select! {
            _ = interrupt.recv() => true,
            _ = terminate.recv() => true,
            // A terminal that is closed sends its signal more than once: from the shell, and from the system when that
            // has ended.
            () = received(&mut hangup) => false,
        };
        stop.send_replace(true);
        if asks && std::mem::replace(&mut is_asked, true) {
            process::exit(INTERRUPTED.into());
        }
    }
}

async fn received(signal: &mut Option<Signal>) {
    match signal {
        Some(signal) => drop(signal.recv().await),
        None => std::future::pending().await,
    }
}

/// Whether it was started with `nohup`: then a terminal that is closed ends nothing. Without an answer of the system it
/// was not.
fn ignores_hangup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 == 1)
}

/// The exit code after Ctrl-C, by the convention of shells.
pub(crate) const INTERRUPTED: u8 = 130;

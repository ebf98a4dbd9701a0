//! One pass over a run that was recorded: it is simulated again, and every tick goes to all writers.

use std::io;

use anyhow::Context;
use baudbot_recording::Replay;
use baudbot_sim::World;

use super::window::Window;
use crate::error;
use crate::run;
use crate::signals::Stop;
use crate::text::tell;

/// Makes something of what it sees.
pub(super) trait Sink {
    /// A tick has begun, its sensors are read.
    fn tick(&mut self, world: &World) -> io::Result<()>;

    /// There is no more to come.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

/// A file that is being written.
pub(super) struct Output {
    /// The output's name, for errors.
    pub(super) name: String,
    /// The number of ticks from one that the output gets to the next.
    pub(super) every: u64,
    pub(super) sink: Box<dyn Sink>,
}

impl Output {
    fn tick(&mut self, world: &World) -> anyhow::Result<()> {
        if !world.tick().is_multiple_of(self.every) {
            return Ok(());
        }
        self.sink.tick(world).map_err(|error| error::from_output(error, &self.name))
    }

    fn finish(self) -> anyhow::Result<()> {
        self.sink.finish().map_err(|error| error::from_output(error, &self.name))
    }
}

/// Shows all ticks of a window to all outputs, and ends these. Returns whether it came to its end, before a signal did.
pub(super) fn run(
    (mut replay, mut world): (Replay, World),
    window: &Window,
    mut outputs: Vec<Output>,
    stop: &Stop,
    quiet: bool,
) -> anyhow::Result<bool> {
    let bar = run::progress(Some(window.to_tick - window.from_tick), quiet);
    replay.seek(&mut world, window.from_tick).context("the recording")?;
    // The beginning of the window may lack something.
    while world.tick() < window.from_tick && replay.step(&mut world).context("the recording")? {}
    let mut is_whole = true;
    loop {
        let seen = world.tick();
        if seen > window.to_tick {
            break;
        }
        outputs.iter_mut().try_for_each(|output| output.tick(&world))?;
        if seen.is_multiple_of(TICKS_A_LOOK) {
            bar.set_position(seen.saturating_sub(window.from_tick));
            if stop.is_wanted() {
                is_whole = false;
                break;
            }
        }
        if seen >= window.to_tick {
            break;
        }
        if !replay.step(&mut world).with_context(|| format!("tick {seen}: the recording"))? {
            break;
        }
    }
    bar.finish_and_clear();
    outputs.into_iter().try_for_each(Output::finish)?;
    if let Some(difference) = replay.difference() {
        tell!("warning: the replay differs from the recorded run, from {difference}");
    }
    if !is_whole {
        let at_s = world.time().as_seconds();
        tell!("note: stopped at {at_s} s of the run; the outputs end there");
    }
    Ok(is_whole)
}

/// The end of a writer that did not report one.
pub(super) fn lost() -> io::Error {
    io::Error::other("its writer is gone")
}

/// Ticks between two checks for Ctrl-C.
const TICKS_A_LOOK: u64 = 64;

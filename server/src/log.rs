//! Events of worlds, for the operator's log.

/// Logs an event of a world: `event!(this, info, field = value, "text")`. Every one says which world, and when by its
/// own clock. `this` has a
/// `name` and a `world`. Nothing is computed if nobody logs it.
macro_rules! event {
    ($this:expr, $level:ident, $($rest:tt)+) => {
        tracing::$level!(
            world = &*$this.name,
            tick = $this.world.tick(),
            time_s = $this.world.time().as_seconds(),
            $($rest)+
        )
    };
}

pub(crate) use event;

//! The server of baudbot: worlds on a pool of threads, and gRPC services around them.
//!
//! From the outside in:
//!
//! 1. [`Server`] listens on TCP, Unix sockets and in-process pipes, with health and reflection. The `gate` limits its
//!    connections.
//! 2. Three services face three kinds of client: `control` the operator, `brain_link` the brains, `observe` the observers.
//!    They know the contract, and worlds only by their handles.
//! 3. `page` is the viewer for browsers: a client like any other, whose `calls` come over a WebSocket and go through a `pipe` in memory. On
//!    the same port, `metrics` are for monitoring.
//! 4. `registry` finds a world's handle by name. A `message` is all that passes to a world; answers are a `report` for
//!    operators, a `frame` for observers, `measures` for monitoring. `convert` is the only folder that names both the contract's
//!    types and these.
//! 5. `mailbox` decides where a message is handled: on a thread of the `pool`, which says which world comes first, or inline by
//!    its sender.
//! 6. `actor` is a world with all that happens to it: it alone touches the world. [`Pace`] says when a tick may end, `sessions`
//!    which brains are attached and which answers are owed, `observers` get frames, `recording` writes files,
//!    `state` keeps the world over a restart. `endpoint` is the
//!    laptop's end of a brain's ports: what it writes, checked and turned into bytes. `beliefs` are what brains publish.
//!    [`DirectWorld`] is that without a server, and [`drive()`] a test of a brain in one.
//! 7. [`Embedded`] is a server for a program without a network and without threads, such as a page. All that needs a network is the
//!    feature `network`, and what is asked of the operating system is in `system`.
//!
//! A brain in a test: [`drive()`]. A server in the process of a test:
//!
//! ```
//! # #[tokio::main(flavor = "current_thread")]
//! # async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use baudbot_server::{Lockstep, Pace, Server, WorldConfig};
//! use baudbot_sim::Scenario;
//!
//! let scenario = baudbot_scenario::parse(include_str!("../../catalogue/scenarios/wander.toml"))?;
//! let world = WorldConfig::new("wander", scenario).pace(Pace::Lockstep(Lockstep::default()));
//! let server = Server::builder().world(world).in_process().await?;
//! let channel = server.channel().await?; // for any gRPC client of package baudbot.v1
//! # drop(channel);
//! server.shutdown().await;
//! # Ok(())
//! # }
//! ```

// What only listeners, metrics and logs use is there without them, too.
#![cfg_attr(not(feature = "network"), allow(dead_code, unused_imports))]

mod access;
mod actor;
#[cfg(feature = "network")]
mod address;
mod annotate;
mod answers;
mod audit;
mod beliefs;
mod brain_link;
mod cables;
mod calls;
mod clock;
mod columns;
mod control;
mod convert;
#[cfg(feature = "network")]
mod drive;
mod embedded;
mod endpoint;
mod frame;
#[cfg(feature = "network")]
mod gate;
mod in_bytes;
mod limits;
mod log;
mod mailbox;
mod measures;
mod message;
#[cfg(feature = "network")]
mod metrics;
mod observe;
mod observers;
mod pace;
#[cfg(feature = "network")]
mod page;
#[cfg(feature = "network")]
mod pipe;
mod pool;
mod quote;
mod recording;
mod registry;
mod report;
#[cfg(feature = "network")]
mod server;
mod sessions;
mod state;
mod system;
mod thinking;
mod trainer;
mod truth;

pub use actor::{DirectWorld, OnBelief, OnTick, Progress};

#[cfg(feature = "network")]
pub use address::{Address, BadAddress};
pub use audit::AuditLog;
pub use columns::{sensor_columns, sensor_columns_with_units, state_columns, state_values};
pub use convert::pace_of;
#[cfg(feature = "network")]
pub use drive::{Drive, DriveCollision, DriveError, PathPoint, drive, drive_each};
pub use embedded::{Embedded, Services};
#[cfg(feature = "network")]
pub use gate::{Tls, TlsError};
pub use limits::Limits;
pub use pace::{Lockstep, Pace, Timed, Watchdog, WatchdogPolicy};
#[cfg(feature = "network")]
pub use page::{Film, NoFilm};
pub use registry::MAX_WORLDS;
#[cfg(feature = "network")]
pub use server::{Builder, Server, ServerError, WorldConfig};
pub use state::{Checked, Found, KeptWorld, RecoverError, Recovered, Soundness, StateError, StateFolder};
pub use state::{Kind as StoredKind, Listed, Storage, Stored};
pub use system::raise_descriptor_limit;
pub use thinking::ProcessorTime;

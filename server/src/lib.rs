//! The server of baudbot: worlds on threads of their own, and gRPC services around them.
//!
//! From the outside in:
//!
//! 1. [`Server`] listens on TCP, Unix sockets and in-process pipes, with health and reflection.
//! 2. Three services face three kinds of client: `control` the operator, `brain_link` the brains, `observe`
//!    the observers. They know the contract and no world.
//! 3. `endpoint` is the laptop's end of a brain's ports: what it writes, checked and turned into bytes.
//! 4. `registry` finds a world by name; a `letter` is all that passes between a service and a world.
//! 5. `host` is a world's thread: it alone touches the world. [`Pace`] says when a tick ends, `sessions` who
//!    is attached and whom the world waits for, `observers` who watches, in `details` if they want; `beliefs` is what
//!    brains publish for them.
//!
//! 6. `page` is the viewer for browsers: a program like any other, behind a WebSocket and a `pipe` in memory. On the
//!    same port, `metrics` tells monitoring how all worlds are.
//!
//! `convert` is the only folder that names both the contract's types and the domain's.
//!
//! A test that wants a robot in its own process:
//!
//! ```
//! # #[tokio::main(flavor = "current_thread")]
//! # async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use baudbot_server::{Lockstep, Pace, Server, WorldConfig};
//! use baudbot_sim::Scenario;
//!
//! let scenario = baudbot_scenario::parse(include_str!("../../scenarios/wander.toml"))?;
//! let world = WorldConfig::new("wander", scenario).pace(Pace::Lockstep(Lockstep::default()));
//! let server = Server::builder().world(world).in_process().await?;
//! let channel = server.channel().await?; // for any gRPC client of package baudbot.v1
//! # drop(channel);
//! server.shutdown().await;
//! # Ok(())
//! # }
//! ```

mod address;
mod annotate;
mod beliefs;
mod blocking;
mod brain_link;
mod columns;
mod control;
mod convert;
mod descriptors;
mod details;
mod endpoint;
mod gate;
mod host;
mod letter;
mod log;
mod metrics;
mod observe;
mod observers;
mod pace;
mod page;
mod pipe;
mod recording;
mod registry;
mod room;
mod seldom;
mod server;
mod sessions;
mod words;

pub use address::{Address, BadAddress};
pub use columns::{sensor_columns, sensor_columns_with_units, state_columns, state_values};
pub use convert::pace_of;
pub use descriptors::raise_descriptor_limit;
pub use host::OnTick;
pub use pace::{Lockstep, Pace, Timed, Watchdog, WatchdogPolicy};
pub use page::Film;
pub use server::{Builder, Server, ServerError, WorldConfig};

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
//!    operators, a `frame` for observers, `measures` for monitoring. `convert` makes the contract's types of the
//!    world's, and back.
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
//! # Threads
//!
//! - **Actors.** A world is an actor (`actor/`). Only the actor touches the world, and it does one thing at a
//!   time: handle messages, begin a tick, finish a tick, wait. It has no async code.
//! - **Messages** (`message/`) are the only way into a world. Answers come back through oneshot channels, Turns
//!   and frames through bounded ones: who does not read loses Turns or frames, and never slows the world down.
//! - **The pool** (`pool/`) has a thread per processor, `worlds 0` and so on, and no more than there are worlds.
//!   Its order is in `pool/queue.rs`, without threads or a clock: worlds of the wall clock that are due, the
//!   earliest deadline first; worlds that a message has woken; worlds that have had a slice of half a millisecond
//!   and have more to do. One of the last that has waited for 0.1 s goes first, once in 20 ms.
//! - **What takes long or blocks** leaves these threads: ticks of more than 10 ms go to as many threads `long
//!   ticks`, a world that waits for a disk to a thread `world apart`, a world with an `OnTick` (for `--csv` and
//!   tests) to a thread of its own, `world NAME`, which waits until it returns.
//! - **Mailboxes** (`mailbox.rs`). Waking a thread takes longer than a tick of a small world. So the caller that
//!   posts a message runs the actor inline, with the tick that has become due, if ticks are short
//!   (`actor/runner.rs`), no `OnTick` observes them, and no other thread is at it. In lockstep a `Step` thus
//!   becomes the next `Turn` on the thread that read it from the network.
//! - **Without threads** (`pool/tasks.rs`, `Builder::without_threads`) worlds are tasks of the caller's runtime,
//!   and all instants are that runtime's (`clock.rs`): a test with a paused clock passes hours at once, as
//!   `tests/tests/network/` does.
//! - **Without a network** (`embedded.rs`, without the feature `network`) calls come through a channel, and
//!   everything runs in turns on one thread: the server of the page without installation (`viewer/page/`). What
//!   the operating system is asked is in `system/`.
//! - **Statuses** are read by the caller who asks, inline, from a world that rests or waits in the queue; one
//!   within a tick answers after it. `ListWorlds` (`control/list.rs`) asks all at once, and after a second gives
//!   the last known answer.
//! - **Lookahead** (`crates/sim/src/world/lookahead.rs`, `actor/lookahead.rs`) ends ticks whose missing answers
//!   cannot have reached their robots. `sessions/debt.rs` has the states of a brain's answers.
//! - **The gRPC runtime** (tokio) is chosen by the embedding program; `baudbot` uses one thread for it, and a
//!   second one for Ctrl-C. Services know the contract, and worlds by their handles only (`registry.rs`). Long
//!   work without a world (parsing a scenario, fingerprints) goes to tokio's blocking threads.
//! - **The gate** (`gate/`) limits the connections of all listeners, closes idle ones, encrypts (`tls`), and lets
//!   a call through only if its caller may make it (`calls`). A connection reads 16 KiB at most before its
//!   streams have their turn. The server never stops reading a stream: what a world does not take is discarded
//!   and counted (`sessions/quota.rs`).
//! - **Access** (`access/`) says who a caller is: by a token, by the pipe in memory, or by the peer of a Unix
//!   socket. What each call needs is one table, `crates/access/src/need.rs`; a call that is not in it is refused.
//!   A brain's robots are checked with its Hello; a stream ends when its token does.
//! - **The audit log** (`audit/`): the gate begins and ends each line, the registry adds the world by a variable
//!   of the task, a thread writes it.
//! - **Limits** (`limits/`): one table of names, options, defaults and words (`LIMITS`), values (`Limits`), and the
//!   use of them (`InForce`), whose guards give back what they stand for. Memory is counted by walking what is in it (`crates/sim/src/heap/`).
//! - **The page** (`page/`) is a client: its calls (`calls/`) come over its WebSocket (`page.proto`) and go to
//!   the gRPC services through a pipe in memory, one connection per page. Beliefs (`beliefs.rs`) bypass the
//!   world, from the brains' streams to observers.
//! - **Metrics** (`metrics/`): every world gets a message, also while it is ahead of its brains, and answers with
//!   numbers. Events are logged with the world's time (`log.rs`).
//! - **A brain's hold** on its robots is a `Lease` (`message/attach.rs`): wherever it is dropped, the robots are
//!   released, and stop if their brain has asked for it (`actor/final_command.rs`).
//! - **Trainers** (`trainer/`) hold robots by the sessions of brains, and their Steps take the same way
//!   (`brain_link/steps.rs`). They are another `Recipient`, which is sent the truth (`message/truth.rs`), on a listener
//!   of their own (`server/router.rs`).
//! - **Watchers of cables** (`cables.rs`): while there is one, its robot's lines keep the bytes that are taken at
//!   their ends (`crates/sim/src/link/tape.rs`), outside the state; `crates/sim/src/cable.rs` reads them at the
//!   beginning and the end of each tick.
//! - **State that is kept** (`state/`, `actor/state.rs`): a world writes its journal on its own thread before
//!   anybody is told, where it waits for its brains; elsewhere a thread `state` writes for all worlds. A second
//!   one, `state sync`, forces files onto the disk, and closes journals. Disk and clock are behind a trait
//!   (`state/storage.rs`), which tests simulate.
//! - **A recording** has a thread that writes its file (`recording/thread.rs`).
//! - **`baudbot run`** in lockstep has world and brains on the main thread (`cli/src/run/direct.rs`). Its
//!   `DirectWorld` (`actor/direct.rs`) is the same actor without mailbox, thread and Turns; `drive` (`drive.rs`)
//!   is a loop around one. With `--over grpc`, and where a server is needed, it is a server and its clients on
//!   the gRPC thread (`served.rs`); a `Progress` tells how far the world is.
//! - **A panic** of a world ends that world only (`catch_unwind` in `mailbox.rs`).
//!
//! # In a program
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

// Code that only listeners, metrics and logs use is there without them, too.
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
mod control;
mod convert;
#[cfg(feature = "network")]
mod drive;
mod embedded;
mod endpoint;
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

pub use actor::{DirectWorld, OnBelief, OnTick, Progress};

#[cfg(feature = "network")]
pub use address::{Address, BadAddress};
pub use audit::AuditLog;
pub use convert::{pace_of, world_status};
#[cfg(feature = "network")]
pub use drive::{Drive, DriveCollision, DriveError, PathPoint, drive, drive_each};
pub use embedded::{Embedded, Services};
#[cfg(feature = "network")]
pub use gate::{Tls, TlsError};
pub use limits::{LIMITS, Limit, LimitInfo, Limits, Unit, Usual};
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

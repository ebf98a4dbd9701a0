//! A server for hours, with all that clients do at once: `./test soak [HOURS]`.
//!
//! The server is `baudbot serve`, with tokens and TLS. Fifty viewers watch its worlds, one of which never reads; a thousand
//! brains come, drive for a while and go; recordings follow one another; worlds are made and deleted. Memory, descriptors and threads
//! of the server are sampled, and a line is fitted through what comes after the first minutes: it must be flat. The world that the
//! stalled viewer watches must lag no more than another one with as many viewers that read.

mod clients;
mod samples;
mod server;

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use tokio::time::{Instant, sleep};

use clients::Crowd;
use samples::{Sample, Samples};

/// The time between two samples.
const EVERY: Duration = Duration::from_secs(5);

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (Some(program), minutes) = (arguments.next(), arguments.next()) else {
        eprintln!("usage: soak PROGRAM [MINUTES]");
        return ExitCode::FAILURE;
    };
    let minutes = minutes.map_or(10.0, |text| text.parse().expect("minutes"));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    baudbot_server::raise_descriptor_limit();
    if runtime.block_on(soak(Path::new(&program), minutes)) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs a server and its clients for so long, and returns how it went.
async fn soak(program: &Path, minutes: f64) -> bool {
    let folder = tempfile::tempdir().expect("a folder");
    let (child, address) = server::start(program, folder.path()).await;
    let process = child.id().expect("it runs");
    println!("the server listens on {address}, process {process}");
    let crowd = Crowd::start(&address, folder.path()).await;
    let (began, time) = (Instant::now(), Duration::from_secs_f64(minutes * 60.0));
    let mut samples = Samples::default();
    println!("{}", Sample::HEAD);
    while began.elapsed() < time {
        sleep(EVERY).await;
        let sample = Sample::take(process, began.elapsed(), crowd.counts());
        samples.add(sample);
    }
    let lag = crowd.lag().await;
    drop(crowd);
    samples.judge() & lag.judge()
}

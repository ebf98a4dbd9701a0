//! What the way to the brain costs: brains in another process, over TCP on loopback.
//!
//! `cargo bench -p baudbot-tests --bench network [-- n1 n2 n3 n4]`. Each figure is measured five times; a line has the
//! median and the five. This process is the server, and starts itself anew as the brains' process.
//!
//! - **n1**: one brain in lockstep, a reading and a command in each tick, next to a bare tonic ping-pong of 64 bytes.
//! - **n2**: one brain at 9600 baud and ticks of 1 ms, with and without lookahead.
//! - **n3**: 22 brains in lockstep, eight infra-red sensors and encoders each, on 22 connections and on one.
//! - **n4**: 1,000 such robots in real time, their brains on 10 streams.

mod bare;
mod brains;
mod figures;
mod worlds;

use std::time::Duration;

use figures::Line;
use worlds::{Load, crowd, lone, slow};

/// How often each figure is measured.
const RUNS: usize = 5;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    if arguments.first().is_some_and(|role| role == "brains") {
        return runtime.block_on(brains::main(&arguments[1..]));
    }
    let wanted = |name: &str| arguments.is_empty() || arguments.iter().any(|argument| argument == name);
    runtime.block_on(async {
        if wanted("n1") {
            one_brain().await;
        }
        if wanted("n2") {
            slow_cable().await;
        }
        if wanted("n3") {
            team().await;
        }
        if wanted("n4") {
            real_time().await;
        }
    });
}

/// N1. The two are measured in turn, so that both meet the same machine.
async fn one_brain() {
    let (mut bare, mut ticks, mut shares) =
        (Line::new("n1 bare ping-pong, 1/s"), Line::new("n1 lockstep, ticks/s"), Line::new("n1 share"));
    for _ in 0..RUNS {
        let pings = bare::measure(PINGS).await;
        let load = Load { connections: 1, streams: 1, ticks: PINGS };
        let rate = worlds::lockstep(lone(), &load, "constant", true).await;
        bare.push(pings);
        ticks.push(rate);
        shares.push(rate / pings);
    }
    bare.print();
    ticks.print();
    shares.print();
}

async fn slow_cable() {
    let (mut off, mut on) = (Line::new("n2 lookahead off, ticks/s"), Line::new("n2 lookahead on, ticks/s"));
    for _ in 0..RUNS {
        let load = Load { connections: 1, streams: 1, ticks: 40_000 };
        off.push(worlds::lockstep(slow(), &load, "avoid", false).await);
        on.push(worlds::lockstep(slow(), &load, "avoid", true).await);
    }
    off.print();
    on.print();
}

async fn team() {
    for connections in [22, 1] {
        let mut line = Line::new(&format!("n3 22 streams on {connections} connections, cycles/s"));
        for _ in 0..RUNS {
            let load = Load { connections, streams: 22, ticks: 4_000 };
            line.push(worlds::lockstep(crowd(22), &load, "constant", true).await);
        }
        line.print();
    }
    let mut line = Line::new("n3 22 robots on one stream, cycles/s");
    for _ in 0..RUNS {
        let load = Load { connections: 1, streams: 1, ticks: 4_000 };
        line.push(worlds::lockstep(crowd(22), &load, "constant", true).await);
    }
    line.print();
}

async fn real_time() {
    let load = Load { connections: 10, streams: 10, ticks: 2_000 };
    let mut kept = Line::new("n4 ticks on time, %");
    let mut prompt = Line::new("n4 ticks less than 1 ms late, %");
    let (mut server, mut brains) =
        (Line::new("n4 CPU of the server, %"), Line::new("n4 CPU of the brains, %"));
    for _ in 0..RUNS {
        let outcome = worlds::real_time(crowd(1_000), &load).await;
        kept.push(outcome.on_time * 100.0);
        prompt.push(outcome.within_1_ms * 100.0);
        server.push(outcome.server_cpu * 100.0);
        brains.push(outcome.brains_cpu * 100.0);
        println!(
            "n4 turns lost {}, most late {:?}",
            outcome.lost,
            Duration::from_nanos(outcome.most_late_ns)
        );
    }
    for line in [kept, prompt, server, brains] {
        line.print();
    }
    println!("n4 peak memory of the server {:.0} MB", figures::peak_memory_mb());
}

/// Exchanges of one run of N1.
const PINGS: u64 = 20_000;

//! The speed of a world: in process, in process with a brain, and in lockstep over pipe, Unix socket and TCP. Run
//! with `cargo bench -p baudbot-tests`. An item is a tick; compare the ratios, machines differ.

use baudbot_client::{Client, Signals, connect};
use baudbot_server::Server;
use baudbot_sim::World;
use baudbot_tests::system::{client, lockstep, serve, serve_on_ports};
use baudbot_tests::{ARSIM, InProcess, KHEPERA, WANDER, crowd, scenario};
use divan::Bencher;
use divan::counter::ItemsCount;

fn main() {
    divan::main();
}

const TICKS: u64 = 2000;

fn toml(name: &str) -> String {
    match name {
        "arsim" => ARSIM.into(),
        "wander" => WANDER.into(),
        "khepera" => KHEPERA.into(),
        _ => crowd(&(0..10).map(|i| format!("r{i}")).collect::<Vec<_>>()),
    }
}

#[divan::bench(args = ["arsim", "wander", "khepera", "crowd of 10"], sample_count = 20)]
fn world_alone(bencher: Bencher<'_, '_>, name: &str) {
    let scenario = std::sync::Arc::new(scenario(&toml(name), &["end={}", "collision=stop-robot"]));
    bencher.counter(ItemsCount::new(TICKS)).with_inputs(|| World::new(scenario.clone())).bench_refs(
        |world| {
            for _ in 0..TICKS {
                world.begin();
                world.finish(&[]);
            }
        },
    );
}

#[divan::bench(args = [("arsim", "constant:left=0.3,right=0.5"), ("wander", "avoid")], sample_count = 20)]
fn world_and_brain(bencher: Bencher<'_, '_>, (name, brain): (&str, &str)) {
    let local = || InProcess::new(scenario(&toml(name), &["end={}", "collision=stop-robot"]), brain).unwrap();
    bencher.counter(ItemsCount::new(TICKS)).with_inputs(local).bench_refs(|local| local.run(TICKS));
}

#[divan::bench(args = ["pipe", "unix", "tcp"], sample_count = 10)]
fn lockstep_arsim_over(bencher: Bencher<'_, '_>, transport: &str) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    let attach = || {
        runtime.block_on(async {
            let scenario = scenario(ARSIM, &["end={}", "collision=stop-robot"]);
            let (server, client): (Server, Client) = match transport {
                "pipe" => {
                    let server = serve(scenario, lockstep()).await;
                    let client = client(&server).await;
                    (server, client)
                }
                _ => {
                    let server = serve_on_ports(scenario, lockstep()).await;
                    let address = server.addresses()[usize::from(transport == "tcp")].to_string();
                    (server, connect(&address).await.expect("connected"))
                }
            };
            let robot = client.attach("w", "robot").await.expect("attached");
            (server, robot)
        })
    };
    bencher.counter(ItemsCount::new(TICKS)).with_inputs(attach).bench_refs(|(_, robot)| {
        runtime.block_on(async {
            for _ in 0..TICKS {
                robot.turn().await.expect("a stream").expect("a turn");
                robot.drive(Signals { left: 0.3, right: 0.5 }).await.expect("an answer");
            }
        });
    });
}

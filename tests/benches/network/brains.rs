//! The other process: the brains.

use std::time::Instant;

use baudbot_brains::catalogue;
use baudbot_client::{Action, Brain, Client, Fleet, connect};
use tokio::task::JoinSet;

use crate::{bare, figures};

/// `ping ADDRESS N`, or `drive ADDRESS ROBOTS CONNECTIONS STREAMS TICKS BRAIN`. With 0 ticks until the run is over, and
/// what is told is the processor's time in seconds.
pub(crate) async fn main(arguments: &[String]) {
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let number = |text: &str| text.parse::<usize>().expect("a number");
    let told = match arguments[..] {
        ["ping", address, exchanges] => bare::ping(address, number(exchanges) as u64).await,
        ["drive", address, robots, connections, streams, ticks, brain] => {
            let plan =
                Plan { robots: number(robots), connections: number(connections), streams: number(streams) };
            plan.drive(address, number(ticks) as u64, brain).await
        }
        _ => panic!("{arguments:?}"),
    };
    println!("{told}");
}

struct Plan {
    robots: usize,
    connections: usize,
    streams: usize,
}

impl Plan {
    async fn drive(&self, address: &str, ticks: u64, brain: &str) -> f64 {
        let mut clients = Vec::new();
        for _ in 0..self.connections {
            clients.push(connect(address).await.expect("connected"));
        }
        let mut fleets = Vec::new();
        for stream in 0..self.streams {
            let client: &Client = &clients[stream % self.connections];
            let robots: Vec<_> = (0..self.robots)
                .filter(|robot| robot % self.streams == stream)
                .map(|robot| format!("r{robot:04}"))
                .collect();
            let robots: Vec<_> = robots.iter().map(String::as_str).collect();
            fleets.push(client.attach_many("w", &robots).await.expect("attached"));
        }
        let mut tasks = JoinSet::new();
        for fleet in fleets {
            let brains = brains(&fleet, brain);
            tasks.spawn(drive(fleet, brains, ticks));
        }
        let seconds = tasks.join_all().await.into_iter().fold(0.0, f64::max);
        if ticks == 0 { figures::cpu_s() } else { ticks as f64 / seconds }
    }
}

fn brains(fleet: &Fleet, brain: &str) -> Vec<Box<dyn Brain + Send>> {
    if brain == "constant" {
        return Vec::new();
    }
    fleet.bodies().iter().map(|body| catalogue::brain(brain, 1, body).expect("a brain")).collect()
}

/// Seconds that so many ticks took. Without brains each robot gets the same command every time.
async fn drive(mut fleet: Fleet, mut brains: Vec<Box<dyn Brain + Send>>, ticks: u64) -> f64 {
    let mut begun = Instant::now();
    let mut first = None;
    loop {
        let turns = match fleet.turns().await {
            Ok(Some(turns)) => turns,
            // The server stops.
            Err(_) if ticks == 0 => break,
            end => panic!("the run is over: {end:?}"),
        };
        let tick = turns[0].1.tick;
        if first.is_none() && tick >= WARM_UP {
            (first, begun) = (Some(tick), Instant::now());
        }
        if ticks > 0 && first.is_some_and(|first| tick >= first + ticks) {
            break;
        }
        let action = |(robot, turn): &(usize, _)| match brains.get_mut(*robot) {
            Some(brain) => (*robot, brain.step(turn)),
            None => (*robot, Action::drive(0.3, 0.5)),
        };
        let actions: Vec<_> = turns.iter().map(action).collect();
        let acted = fleet.act(&actions).await;
        assert!(acted.is_ok() || ticks == 0, "{acted:?}");
    }
    begun.elapsed().as_secs_f64()
}

const WARM_UP: u64 = 500;

//! A brain that does the same whenever it is asked the same, and comes back to its server; and the run that it has without one.

use std::convert::Infallible;
use std::sync::mpsc::{Receiver, channel};

use baudbot_client::{Action, Attachment, Body, Brain, Reconnect, Turn};
use baudbot_run::{DrivenWorld, Driver, LockstepWorld};
use baudbot_server::WorldConfig;
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;

pub(crate) struct Same;

impl Brain for Same {
    fn step(&mut self, turn: &Turn) -> Action {
        let near = |i: usize| {
            let reading = turn.readings.get(i).and_then(Option::as_ref);
            reading.and_then(|reading| reading.values.first()).copied().unwrap_or(0.5)
        };
        let swing = 0.05 * ((turn.tick / 40) % 5) as f64;
        Action::drive((0.1 + 0.2 * near(0) + swing).clamp(-1.0, 1.0), (0.3 - 0.2 * near(4)).clamp(-1.0, 1.0))
    }
}

/// Drives robots from a thread until the program ends. The program's output comes out here.
pub(crate) fn drive(address: &str, world: &str, robots: &[&str]) -> Receiver<String> {
    let attachment = Attachment {
        connect: address.to_owned(),
        credentials: None,
        world: world.to_owned(),
        robots: robots.iter().map(|robot| (*robot).to_owned()).collect(),
        brain: "same".to_owned(),
        thinks_as_scenario: true,
        reconnect: Reconnect::default(),
    };
    let (told, lines) = channel();
    std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let tell = |line: &str| drop(told.send(line.to_owned()));
        let driven = runtime.block_on(attachment.drive(|_| Ok::<_, Infallible>(Same), tell));
        let _ = told.send(format!("ended: {driven:?}"));
    });
    lines
}

/// The fingerprint after so many ticks with this brain on all robots, without any server.
pub(crate) fn undisturbed(scenario: Scenario, ticks: u64) -> u64 {
    let driver = |spec: &RobotSpec| Some(Driver::new(Body::from(spec), Same));
    let drivers: Vec<_> = scenario.robots.iter().map(driver).collect();
    let mut world = WorldConfig::new("w", scenario).direct().unwrap();
    world.attach("same", &(0..drivers.len()).collect::<Vec<_>>());
    let mut driven = DrivenWorld { world, drivers };
    while driven.world.world().tick() < ticks {
        assert!(driven.advance(|_| Ok(())).unwrap(), "the run has ended");
    }
    driven.world.world().hash()
}

//! The input of robots and their devices from programs that speak to them: any bytes, while the world runs.

use std::sync::Arc;

use anyhow::Context;
use baudbot_scenario::Override;
use baudbot_sim::{Input, Scenario, World};

use super::{Target, outcome};

pub(super) fn targets() -> anyhow::Result<Vec<Target>> {
    let worlds: Vec<_> =
        SCENARIOS.iter().map(|&(toml, changes)| world(toml, changes)).collect::<Result<_, _>>()?;
    let seed = |(which, words): (u8, &[u8])| [&[which][..], words].concat();
    Ok(vec![Target {
        name: "dialogues",
        what: "firmware and devices that are told any bytes while they run",
        seeds: SEEDS.map(seed).to_vec(),
        words: WORDS,
        run: Box::new(move |bytes| run(&worlds, bytes)),
    }])
}

fn world(toml: &str, changes: &[&str]) -> anyhow::Result<World> {
    let changes = changes.iter().map(|text| Override::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let scenario: Scenario =
        baudbot_scenario::parse_with(toml, &changes).context("a scenario of the dialogues")?;
    Ok(World::new(Arc::new(scenario)))
}

/// The first byte chooses the world. The others are written in pieces, one each tick, to the robot and to its devices.
fn run(worlds: &[World], bytes: &[u8]) -> u64 {
    let Some((&which, bytes)) = bytes.split_first() else { return 0 };
    let mut world = worlds[usize::from(which) % worlds.len()].clone();
    let sensors = world.scenario().robots[0].sensors.len();
    for piece in bytes.chunks(6).take(MOST_TICKS) {
        let at = world.begin().first().map(|turn| turn.at);
        let at = at.unwrap_or_else(|| world.time());
        for sensor in 0..sensors {
            world.write_port(0, sensor, world.time(), piece);
        }
        world.finish(&[Input { robot: 0, at, bytes: piece }]);
    }
    for _ in 0..5 {
        world.begin();
        world.finish(&[]);
    }
    let robot = world.robot(0);
    let heard = format!("{:?}", robot.counters());
    outcome(&sizes(&heard)) ^ robot.commands().min(8) ^ (u64::from(which) % worlds.len() as u64) << 32
}

/// The length of each number in these words: a few more bytes are no news, many more are.
fn sizes(words: &str) -> String {
    let numbers = words.split(|c: char| !c.is_ascii_digit()).filter(|number| !number.is_empty());
    let size = |number: &str| match number {
        "0" => 'z',
        number => char::from(b'a' + number.len().min(20) as u8),
    };
    numbers.map(size).collect()
}

const MOST_TICKS: usize = 40;

const WANDER: &str = include_str!("../../../../catalogue/scenarios/wander.toml");
const LASER: &str = include_str!("../../../../catalogue/scenarios/devices/laser.toml");

const SCENARIOS: &[(&str, &[&str])] = &[
    (WANDER, &[]),
    (WANDER, &["robots.robot.firmware={ protocol = \"bare\", mode = \"poll\" }"]),
    (WANDER, &["robots.robot.firmware={ mode = \"poll\" }"]),
    (WANDER, &["robots.robot.firmware={ protocol = \"khepera\" }"]),
    (LASER, &[]),
    (WANDER, &["robots.robot.firmware={ protocol = \"asercom\" }"]),
];

const SEEDS: [(u8, &[u8]); 6] = [
    (0, &[0x03, 0x10, 0x07, 0x40, 0x20, 0x11, 0x00]),
    (1, &[7, 200, 7, 7, 1, 90]),
    (2, &[0x03, 0x10, 0x07, 0x40, 0x20, 0x11, 0x00]),
    (3, b"D,5,-5\rN\rC,900,-900\rJ,20,64,20,64\rK\rT,1,B\r"),
    (4, b"VV\nPP\nBM\nMD0044072501000\nGD0044072501\nQT\nRS\nSCIP2.0\n"),
    (5, b"D,500,-500\rN\rQ\r\xbc\x01\x02\x03\x04\xb2\xaf\0P,5,5\rK\rR\rH\r"),
];

const WORDS: &[&[u8]] = &[
    b"\r",
    b"\n",
    b"\x00",
    b"D,",
    b"MD0044072501000\n",
    b"BM\n",
    b"SS115200\n",
    b"QT\n",
    b"\xff\xff",
    b"\xb2\x00",
];

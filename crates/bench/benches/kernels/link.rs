//! Bytes over a serial cable, both ways, with what becomes of them at its ends. An item is a byte.

use baudbot_sim::{Input, World};
use baudbot_wire::{frame, write_command};
use divan::Bencher;
use divan::counter::ItemsCount;

/// Ten messages of readings a tick.
const ROBOT: &str = r#"
[[robots]]
name = "robot"
body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }
firmware = { period_ms = 1.0 }
link = { kind = "uart", baud = 1000000 }
sensors.encoders = { kind = "encoders", counts_per_turn = 600, bits = 16, period_ms = 1.0 }
"#;

/// Ticks of a run.
const TICKS: u64 = 100;

/// The bytes that went over the cable in a run in which each turn is answered with ten commands.
fn run(world: &mut World, commands: &[u8]) -> u64 {
    for _ in 0..TICKS {
        world.begin();
        let inputs: Vec<_> = world
            .turns()
            .iter()
            .map(|turn| Input { robot: turn.robot, at: turn.at, bytes: commands })
            .collect();
        world.finish(&inputs);
    }
    let robot = world.robot(0);
    robot.uplink().bytes + robot.downlink().bytes
}

#[divan::bench]
fn uart_both_ways(bencher: Bencher<'_, '_>) {
    let mut world = World::new(baudbot_scenario::parse(ROBOT).expect("a scenario").into());
    world.keep_timeline(0);
    let layout = world.scenario().robots[0].firmware.layout();
    let (mut payload, mut framed) = ([0; frame::MAX_PAYLOAD], [0; frame::MAX_FRAME]);
    let len = write_command(&layout, 0, [0.3, 0.3], &mut payload).expect("a command");
    let len = frame::encode(&payload[..len], &mut framed).expect("a frame");
    let commands = framed[..len].repeat(10);
    let bytes = run(&mut world.clone(), &commands);
    assert!(bytes > TICKS * 300, "{bytes} bytes in {TICKS} ticks");
    bencher
        .counter(ItemsCount::new(bytes))
        .with_inputs(|| world.clone())
        .bench_local_refs(|world| run(world, &commands));
}

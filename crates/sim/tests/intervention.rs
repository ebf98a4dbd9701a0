//! Changes by hand: they happen, they are refused with a reason, and the same ones make the same run.

use baudbot_geometry::Pose;
use baudbot_sim::{Input, Intervention, SimTime, World};
use baudbot_wire::{Layout, frame, message};

const SCENARIO: &str = r#"
seed = 3
collision = "stop-robot"
[[arena.polygons]]
name = "room"
solid = false
points_m = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]
[[arena.circles]]
name = "pillar"
x_m = 1.0
y_m = 0.0
radius_m = 0.2
[[arena.movables]]
name = "ball"
x_m = 0.0
y_m = 1.0
radius_m = 0.1
mass_kg = 0.1
friction = 0.1
[[robots]]
name = "alice"
link = { kind = "uart", baud = 9600 }
firmware = { period_ms = 20.0 }
body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.05 }
[robots.sensors.compass]
kind = "compass"
bits = 8
period_ms = 10.0
[[robots]]
name = "bob"
start = { x_m = -1.0 }
link = { kind = "ideal" }
body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.05 }
"#;

fn world() -> World {
    World::new(baudbot_scenario::parse(SCENARIO).unwrap().into())
}

/// Both brains always drive forwards.
fn tick(world: &mut World) {
    let turns = world.begin().to_vec();
    let mut bytes = [0; frame::MAX_FRAME];
    let layout = world.scenario().robots[0].firmware.layout();
    let mut payload = [0; frame::MAX_PAYLOAD];
    let n = message::write_command(&Layout { ..layout }, 0, [0.2, 0.2], &mut payload).unwrap();
    let n = frame::encode(&payload[..n], &mut bytes).unwrap();
    let inputs: Vec<_> =
        turns.iter().map(|turn| Input { robot: turn.robot, at: turn.at, bytes: &bytes[..n] }).collect();
    world.finish(&inputs);
}

fn run(world: &mut World, ticks: usize) {
    (0..ticks).for_each(|_| tick(world));
}

fn place(robot: &str, x: f64, y: f64) -> Intervention {
    Intervention::PlaceRobot { robot: robot.into(), pose: Pose::new(x, y, 0.5) }
}

fn pull(pulled: bool) -> Intervention {
    Intervention::PullCable { robot: "alice".into(), pulled }
}

fn baud(baud: u32) -> Intervention {
    Intervention::SetBaud { robot: "alice".into(), baud }
}

fn refusal(world: &mut World, intervention: &Intervention) -> String {
    let before = world.hash();
    let error = world.intervene(intervention).unwrap_err().to_string();
    assert_eq!(world.hash(), before, "a refused change changes nothing");
    error
}

#[test]
fn a_robot_is_put_where_there_is_room() {
    let mut world = world();
    run(&mut world, 50);
    world.intervene(&place("alice", -0.5, -1.5)).unwrap();
    let motion = *world.robot(0).motion();
    assert_eq!((motion.pose, motion.speed_m_s), (Pose::new(-0.5, -1.5, 0.5), 0.0));
    assert_eq!(refusal(&mut world, &place("alice", 1.1, 0.0)), "no room: `pillar` is in the way");
    let bob = world.robot(1).motion().pose.position;
    assert_eq!(refusal(&mut world, &place("alice", bob.x, bob.y + 0.1)), "no room: `bob` is in the way");
    assert_eq!(refusal(&mut world, &place("carol", 0.0, 0.0)), "robot: there is no robot `carol`");
    let nowhere = refusal(&mut world, &place("alice", f64::NAN, 0.0));
    assert_eq!(nowhere, "x_m: must be a number from -1000000 to 1000000");
    world.begin();
    assert_eq!(refusal(&mut world, &place("alice", 0.0, 0.0)), "the world is within a tick");
}

#[test]
fn what_is_over_is_not_changed() {
    let toml = format!("end = {{ after_s = 0.1 }}\n{SCENARIO}");
    let mut world = World::new(baudbot_scenario::parse(&toml).unwrap().into());
    run(&mut world, 10);
    assert_eq!(refusal(&mut world, &place("alice", 0.0, 0.0)), "the run has ended");
    world.begin();
    assert_eq!(refusal(&mut world, &place("alice", 0.0, 0.0)), "the run has ended");
}

#[test]
fn a_thing_is_put_where_there_is_room() {
    let mut world = world();
    let place = |x, y| Intervention::PlaceThing { thing: "ball".into(), pose: Pose::new(x, y, 0.0) };
    world.intervene(&place(1.5, 1.5)).unwrap();
    assert_eq!(world.things().next().unwrap().pose, Pose::new(1.5, 1.5, 0.0));
    assert_eq!(refusal(&mut world, &place(0.05, 0.0)), "no room: `alice` is in the way");
    let unknown = Intervention::PlaceThing { thing: "room".into(), pose: Pose::new(0.0, 0.0, 0.0) };
    assert_eq!(refusal(&mut world, &unknown), "thing: there is no thing that is pushed `room`");
}

#[test]
fn a_pulled_cable_loses_bytes_both_ways_until_it_is_plugged_in() {
    let mut world = world();
    run(&mut world, 100);
    assert_eq!((world.robot(0).uplink().lost_bytes, world.robot(0).downlink().lost_bytes), (0, 0));
    world.intervene(&pull(true)).unwrap();
    world.intervene(&pull(true)).unwrap();
    let commands = world.robot(0).commands();
    run(&mut world, 100);
    let lost = world.robot(0).uplink().lost_bytes;
    assert!(lost > 100, "{lost}");
    assert!(world.robot(0).commands() <= commands + 2, "what was past the cable still counts");
    world.intervene(&pull(false)).unwrap();
    run(&mut world, 100);
    assert!(world.robot(0).commands() > commands + 40);
    // The message that was under way when it was plugged in was lost, or its rest was.
    assert!(world.robot(0).uplink().lost_bytes <= lost + 20);
    let of_bob = Intervention::PullCable { robot: "bob".into(), pulled: true };
    assert_eq!(refusal(&mut world, &of_bob), "robot: `bob` has no cable");
}

#[test]
fn another_baud_rate_holds_for_what_is_sent_from_then_on() {
    let messages = |rate: Option<u32>| {
        let mut world = world();
        run(&mut world, 100);
        let before = world.robot(0).uplink().messages;
        rate.into_iter().for_each(|rate| world.intervene(&baud(rate)).unwrap());
        run(&mut world, 200);
        (world.robot(0).uplink().messages - before, world.robot(0).uplink().bad_frames)
    };
    assert_eq!(messages(None), (100, 0));
    assert_eq!(messages(Some(115_200)), (100, 0));
    // A frame takes 0.3 s and more at 300 baud.
    let (slow, bad) = messages(Some(300));
    assert!((4..=8).contains(&slow) && bad == 0, "{slow} {bad}");
    let mut world = world();
    assert_eq!(refusal(&mut world, &baud(0)), "baud: must be 50 to 100000000 here, is 0");
    let of_bob = Intervention::SetBaud { robot: "bob".into(), baud: 9600 };
    assert_eq!(refusal(&mut world, &of_bob), "robot: `bob` has no serial cable");
}

#[test]
fn the_same_changes_make_the_same_run_and_a_reset_forgets_them() {
    let script = [(10, place("alice", 0.0, -1.0)), (30, pull(true)), (45, pull(false)), (60, baud(19_200))];
    let run = |pause: bool| {
        let mut world = world();
        for i in 0..200 {
            for (_, intervention) in script.iter().filter(|(at, _)| *at == i) {
                world.intervene(intervention).unwrap();
            }
            // A clone goes on like the world itself.
            world = if pause { world.clone() } else { world };
            tick(&mut world);
        }
        world
    };
    let ran = run(false);
    assert_eq!(ran.hash(), run(true).hash());
    let mut untouched = world();
    (0..200).for_each(|_| tick(&mut untouched));
    assert_ne!(ran.hash(), untouched.hash());
    assert_eq!(World::new(ran.origin().clone()).hash(), world().hash());
    assert_eq!(ran.time(), SimTime::from_ns(2_000_000_000));
}

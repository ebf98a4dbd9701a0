//! A debugger at a robot's chip in a world.

use std::sync::Arc;
use std::thread;

use baudbot_access::peer::Reach;
use baudbot_port::debug::GdbServer;
use baudbot_sim::World;

use super::client::Client;

/// A robot whose chip does what it is asked over the cable, and waits for that.
fn world() -> World {
    let hex = include_str!("../../../sim/tests/programs/tester.hex");
    let toml = format!(
        "step_ms = 1.0\nsubsteps = 10\n[[robots]]\nname = \"r\"\n\
         body = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}\n\
         link = {{ kind = \"uart\", baud = 9600, bits_per_character = 10 }}\n[robots.pins]\n\
         [robots.microcontroller]\nprogram = {{ file = \"tester.hex\", hex = '''\n{hex}''' }}\n\
         [[robots]]\nname = \"s\"\n\
         body = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}\n\
         start = {{ x_m = 2.0 }}\n"
    );
    World::new(baudbot_scenario::parse(&toml).unwrap_or_else(|error| panic!("{error}")).into())
}

fn tick(world: &mut World, count: u64) {
    for _ in 0..count {
        world.begin();
        world.finish(&[]);
    }
}

#[test]
fn a_world_whose_chip_is_only_looked_at_is_the_same_to_the_last_bit() {
    let mut free = world();
    tick(&mut free, 20);

    let mut debugged = world();
    let server = Arc::new(GdbServer::listen(0, Reach::OwnUser, || false).unwrap());
    let address = server.address();
    assert!(debugged.probe(0, server));
    assert!(
        !debugged.probe(1, Arc::new(GdbServer::listen(0, Reach::OwnUser, || false).unwrap())),
        "it has no chip"
    );
    let ticking = thread::spawn(move || {
        tick(&mut debugged, 20);
        debugged
    });
    let mut client = Client::connect(address);
    for _ in 0..200 {
        client.ask("s");
        client.ask("g");
        client.memory(0x80_0000, 0x900);
    }
    client.ask("D");
    let debugged = ticking.join().unwrap();
    assert_eq!(debugged.hash(), free.hash());
}

#[test]
fn a_clone_of_a_world_has_no_debugger() {
    let mut world = world();
    let server = Arc::new(GdbServer::listen(0, Reach::OwnUser, || false).unwrap());
    assert!(world.probe(0, Arc::clone(&server) as _));
    let mut clone = world.clone();
    // The clone would wait for ever with a debugger.
    tick(&mut clone, 5);
    assert_eq!((clone.tick(), world.tick()), (5, 0));
}

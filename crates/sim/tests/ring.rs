//! Sensors around a body have the readings of their rays, although most of them cast none.

use baudbot_sim::World;
use baudbot_sim::raycast::RayCaster;
use baudbot_sim::sensor::{Device, Infrared, InfraredModel};

/// Robots in a heap, between walls, a post and a crate, each with sensors that look everywhere and open differently.
fn heap() -> World {
    let mut toml = String::from(
        "noise = false\ncollision = \"stop-robot\"\n\
         [[arena.polygons]]\nname = \"room\"\nsolid = false\n\
         points_m = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]\n\
         [[arena.polygons]]\nname = \"wall\"\nsolid = false\nclosed = false\npoints_m = [[0.05, -0.5], [0.06, 0.4]]\n\
         [[arena.movables]]\nname = \"crate\"\nsize_m = [0.05, 0.06]\nx_m = -0.325\ny_m = -0.305\nmass_kg = 0.1\nfriction = 0.3\n\
         [[arena.circles]]\nname = \"post\"\nx_m = 0.24\ny_m = 0.27\nradius_m = 0.03\n\
         [[robots]]\nname = \"r\"\nlink = { kind = \"onboard\" }\nstarts = [\n",
    );
    for i in 0..25 {
        let (x, y) = (f64::from(i % 5) * 0.19 - 0.42, f64::from(i / 5) * 0.19 - 0.4);
        let heading = f64::from(i) * 1.1;
        toml += &format!("{{ name = \"r{i:02}\", x_m = {x:?}, y_m = {y:?}, heading_rad = {heading:?} }},\n");
    }
    toml += "]\nbody = { radius_m = 0.035, mass_kg = 0.15, inertia_kg_m2 = 9.2e-5, wheel_radius_m = 0.0205 }\n\
             motors = { preset = \"e-puck-stepper\" }\n";
    for (i, (opening, rays)) in
        [(0.5, 3), (0.0, 1), (2.9, 5), (3.1, 7), (1.5, 2)].repeat(3).into_iter().enumerate()
    {
        let bearing = i as f64 * 0.43 - 3.0;
        let (x, y) = (0.03 * bearing.cos(), 0.03 * bearing.sin());
        toml += &format!(
            "[robots.sensors.ir_{i:02}]\nkind = \"ir\"\nrays = {rays}\nopening_rad = {opening:?}\nrange_m = 0.13\n\
             mount = {{ x_m = {x:?}, y_m = {y:?}, heading_rad = {bearing:?} }}\nc1_m2 = 2e-4\nc2 = 0.0\n"
        );
    }
    World::new(baudbot_scenario::parse(&toml).unwrap_or_else(|error| panic!("{error}")).into())
}

/// Equations (3.12) and (3.13) of these rays.
fn reading(infrared: &Infrared, distances_m: impl Iterator<Item = Option<f64>>) -> f64 {
    let InfraredModel::Phenomenological { c1_m2, c2 } = infrared.model else { panic!("it reflects") };
    let reflected = |(i, d): (usize, Option<f64>)| {
        let d = d.filter(|d| *d < infrared.range_m);
        d.map_or(0.0, |d| (infrared.fan.cos_kappa(i) * (c1_m2 / (d * d) + c2)).min(1.0))
    };
    (distances_m.enumerate().map(reflected).sum::<f64>() / infrared.fan.len() as f64).clamp(0.0, 1.0)
}

#[test]
fn each_sensor_of_a_ring_reads_what_its_rays_say() {
    let mut world = heap();
    let (mut nothing, mut something) = (0, 0);
    for tick in 0..300 {
        world.begin();
        let caster = RayCaster::new(&world);
        for (own, robot) in world.robots().enumerate() {
            for (sensor, told) in robot.spec().sensors.iter().zip(robot.readings()) {
                let Device::Infrared(infrared) = &sensor.device else { panic!("all are infra-red") };
                let rays = caster.sees(own, sensor);
                let expected = reading(infrared, rays.iter().map(|ray| ray.distance_m));
                assert_eq!(
                    told.values[0].to_bits(),
                    (expected + 0.0).to_bits(),
                    "{} of {own} in tick {tick}",
                    sensor.name
                );
                *if expected == 0.0 { &mut nothing } else { &mut something } += 1;
            }
        }
        drop(caster);
        // Each in a circle of its own.
        let turns = world.turns().to_vec();
        let answers: Vec<_> = turns
            .iter()
            .map(|turn| {
                let turning = (turn.robot % 7) as f64 * 0.1 - 0.3;
                let wheels = baudbot_sim::drive::Wheels { left: 0.3 - turning, right: 0.3 + turning };
                let written = baudbot_sim::Written::Command { sequence: 0, wheels, others: &[] };
                baudbot_sim::Answer { robot: turn.robot, at: turn.at, written }
            })
            .collect();
        world.finish_answers(&answers);
    }
    assert!(nothing > 10_000 && something > 10_000, "{nothing} and {something}");
}

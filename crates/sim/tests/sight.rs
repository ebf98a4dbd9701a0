//! The view of sensors, ray by ray, as drawings show it.

use baudbot_sim::World;
use baudbot_sim::raycast::RayCaster;

use crate::common::world;

fn seen_world() -> World {
    let body =
        "body = { radius_m = 0.1, height_m = 0.2, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }";
    let toml = format!(
        r#"
        [[arena.circles]]
        name = "stool"
        x_m = 1.0
        y_m = 0.0
        radius_m = 0.2
        height_m = 0.4
        [[arena.circles]]
        name = "tower"
        x_m = 3.0
        y_m = 0.0
        radius_m = 0.5
        [[robots]]
        name = "a"
        {body}
        actuators.neck = {{ kind = "turret", min_rad = -1.0, max_rad = 1.0, rate_rad_s = 1.0 }}
        [robots.sensors.low]
        kind = "sonar"
        bearing_rad = 0.0
        opening_rad = 0.0
        rays = 1
        min_m = 0.0
        max_m = 5.0
        [robots.sensors.high]
        kind = "laser"
        mount = {{}}
        turret = "neck"
        height_m = 0.5
        opening_rad = 3.14159265358979312
        rays = 3
        range_m = 5.0
        [robots.sensors.whisker]
        kind = "whisker"
        bearing_rad = 1.57079632679489656
        length_m = 0.5
        [robots.sensors.bumper]
        kind = "bumper"
        opening_rad = 1.0
        rays = 5
        [robots.sensors.compass]
        kind = "compass"
        [[robots]]
        name = "b"
        start = {{ x_m = 0.0, y_m = 0.5 }}
        {body}
        "#
    );
    world(&toml)
}

fn distances(name: &str) -> Vec<Option<f64>> {
    let world = seen_world();
    let robot = world.robot(0);
    let sensor = robot.spec().sensors.iter().find(|sensor| sensor.name == name).unwrap();
    let casts = RayCaster::new(&world).sees(0, sensor);
    let rounded = |d: f64| f64::floor(d * 1e9 + 0.5) / 1e9;
    casts.iter().map(|cast| cast.distance_m.map(rounded)).collect()
}

#[test]
fn each_sensor_sees_what_reaches_up_to_it() {
    assert_eq!(distances("low"), [Some(0.7)], "the stool is before the tower");
    assert_eq!(distances("high"), [None, Some(2.5), None], "it overlooks the stool and the robots");
    assert_eq!(distances("whisker"), [Some(0.3)], "the other robot is in its way");
}

#[test]
fn a_bumper_has_rays_and_a_compass_has_none() {
    assert_eq!(distances("bumper"), [None; 5]);
    assert_eq!(distances("compass"), []);
}

/// A sensor on a stick, 0.39 m before the middle of a disc of 0.2 m, pushed into or through something at 0.21 m or beyond.
#[test]
fn an_eye_that_is_pushed_into_or_through_something_sees_nothing_but_that() {
    let body = "body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }";
    let things = [
        ("block", "[[arena.polygons]]\nname = \"t\"\npoints_m = [[0.21, -1], [2, -1], [2, 1], [0.21, 1]]\n"),
        (
            "low block",
            "[[arena.polygons]]\nname = \"t\"\nheight_m = 0.3\npoints_m = [[0.21, -1], [2, -1], [2, 1], [0.21, 1]]\n",
        ),
        ("pillar", "[[arena.circles]]\nname = \"t\"\nx_m = 1.21\ny_m = 0\nradius_m = 1\n"),
        (
            "thin wall",
            "[[arena.polygons]]\nname = \"t\"\nsolid = false\nclosed = false\npoints_m = [[0.3, -1], [0.3, 1]]\n",
        ),
        ("thin pillar", "[[arena.circles]]\nname = \"t\"\nx_m = 0.3\ny_m = 0\nradius_m = 0.05\n"),
        (
            "door",
            "[[arena.movers]]\nname = \"t\"\noutline_m = [[-0.05, -1], [0.4, -1], [0.4, 1], [-0.05, 1]]\nx_m = 0.3\ny_m = 0\nswing = { to_rad = 0.01, rate_rad_s = 0.001, pause_s = 1000 }\n",
        ),
        (
            "box",
            "[[arena.movables]]\nname = \"t\"\nsize_m = [0.4, 0.4]\nx_m = 0.45\ny_m = 0\nmass_kg = 1\nfriction = 0.3\n",
        ),
        ("nothing", ""),
    ];
    let sensors = "[robots.sensors.laser]\nkind = \"laser\"\nmount = { x_m = 0.39 }\nopening_rad = 1.0\nrays = 5\nrange_m = 10.0\n\
         [robots.sensors.ir]\nkind = \"ir\"\nmount = { x_m = 0.39 }\nopening_rad = 0.5\nrays = 3\nrange_m = 0.5\nc1_m2 = 0.03\nc2 = 0.1\n\
         [robots.sensors.sonar]\nkind = \"sonar\"\nmount = { x_m = 0.39 }\nopening_rad = 0.5\nrays = 3\nmin_m = 0.0\nmax_m = 3.0\n\
         [robots.sensors.whisker]\nkind = \"whisker\"\nmount = { x_m = 0.39 }\nlength_m = 0.1\n\
         [robots.sensors.high]\nkind = \"laser\"\nmount = { x_m = 0.39 }\nheight_m = 0.5\nopening_rad = 0.0\nrays = 1\nrange_m = 0.5\n";
    for (name, thing) in things {
        let mut world = world(&format!("noise = false\n{thing}[[robots]]\nname = \"a\"\n{body}\n{sensors}"));
        let casts = |world: &World, sensor: &str| -> Vec<Option<f64>> {
            let robot = world.robot(0);
            let sensor = robot.spec().sensors.iter().find(|other| other.name == sensor).unwrap();
            RayCaster::new(world).sees(0, sensor).iter().map(|cast| cast.distance_m).collect()
        };
        let covered = if name == "nothing" { None } else { Some(0.0) };
        for sensor in ["laser", "ir", "sonar", "whisker"] {
            let seen = casts(&world, sensor);
            assert!(seen.iter().all(|distance_m| *distance_m == covered), "{name}, {sensor}: {seen:?}");
        }
        let seen = casts(&world, "high");
        let over = if name == "low block" { None } else { covered };
        assert_eq!(seen, [over], "{name}, from above");
        // The readings of devices are those of their rays.
        crate::common::run(&mut world, 20, 0.0, 0.0);
        let robot = world.robot(0);
        let read: Vec<f64> = robot.sensors().map(|sensor| sensor.sample[0]).collect();
        let nothing = name == "nothing";
        assert_eq!(read[0] == 0.0, !nothing, "{name}: {read:?}");
        assert_eq!(read[1] > 0.5, !nothing, "{name}: {read:?}");
        assert_eq!(read[2] == 0.0, !nothing, "{name}: {read:?}");
        assert_eq!(read[3] == 1.0, !nothing, "{name}: {read:?}");
    }
}

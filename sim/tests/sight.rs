//! What sensors see, ray by ray, as drawings show it.

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

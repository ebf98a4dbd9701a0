use std::collections::BTreeSet;

use baudbot_sim::sensor::SensorKind;
use roxmltree::Document;

use super::*;
use crate::svg::path;

const EVERYTHING: &str = include_str!("everything.toml");

fn drawing(toml: &str) -> String {
    draw(&baudbot_scenario::parse(toml).unwrap(), "label")
}

/// All that a reader could read, titles included.
fn texts(picture: &str) -> String {
    let document = Document::parse(picture).unwrap();
    document.descendants().filter_map(|node| node.text()).collect::<Vec<_>>().join("\n")
}

fn robot(name: &str, x_m: f64, more: &str) -> String {
    format!(
        "[[robots]]\nname = \"{name}\"\nstart.x_m = {x_m:?}\n{more}\n[robots.body]\nradius_m = 0.2\nmass_kg = 3.0\n\
         inertia_kg_m2 = 0.2\nwheel_radius_m = 0.1\ndamping_n_s_m = 15.0\nturn_damping_nm_s = 0.78\n"
    )
}

#[test]
fn everything_is_in_the_picture_by_name() {
    let picture = drawing(EVERYTHING);
    let texts = texts(&picture);
    let scenario = baudbot_scenario::parse(EVERYTHING).unwrap();
    for robot in &scenario.robots {
        assert!(texts.contains(&format!("robot {}", robot.name)), "{}", robot.name);
        for sensor in robot.sensors.iter() {
            assert!(texts.contains(&format!("{}.{}: ", robot.name, sensor.name)), "{}", sensor.name);
        }
        for actuator in &robot.actuators {
            assert!(texts.contains(&format!(" {}: ", actuator.name)), "{}", actuator.name);
        }
    }
    let around = &scenario.surroundings;
    let names = around.zones.iter().map(|zone| format!("zone {}: ", zone.name));
    let names = names.chain(around.lights.iter().map(|light| format!("lamp {}: ", light.name)));
    let names = names.chain(around.fields.iter().map(|field| format!("field {}: ", field.name)));
    let names = names.chain(scenario.movers.iter().map(|mover| format!("{}: moves by itself", mover.name)));
    let names = names.chain(scenario.movables.iter().map(|thing| format!("{}: a b", thing.name)));
    let names = names.chain(scenario.arena.polygons().iter().map(|polygon| format!("{}: ", polygon.name)));
    for name in names.chain(["the run ends when".to_owned(), "stool: a pillar, 0.45 m high".to_owned()]) {
        assert!(texts.contains(&name), "{name}");
    }
}

#[test]
fn every_kind_of_sensor_is_tried_here() {
    let scenario = baudbot_scenario::parse(EVERYTHING).unwrap();
    let sensors = scenario.robots.iter().flat_map(|robot| robot.sensors.iter());
    let kinds: BTreeSet<_> = sensors.map(|sensor| sensor.device.kind()).collect();
    // All that there are but `steps`, which needs motors of its own.
    assert_eq!(kinds.len(), SensorKind::ALL.len() - 1, "{kinds:?}");
}

#[test]
fn references_lead_somewhere_and_names_are_used_once() {
    let picture = drawing(EVERYTHING);
    let document = Document::parse(&picture).unwrap();
    let ids: Vec<_> = document.descendants().filter_map(|node| node.attribute("id")).collect();
    let unique: BTreeSet<_> = ids.iter().copied().collect();
    assert_eq!(unique.len(), ids.len(), "{ids:?}");
    for part in picture.split("url(#").skip(1) {
        let id = part.split(')').next().unwrap();
        assert!(unique.contains(id), "{id}");
    }
}

#[test]
fn coordinates_are_numbers_that_a_viewer_can_count_to() {
    let tiny = EVERYTHING.replace("x_m = 900.0", "x_m = 1e6");
    let flea = robot("flea", 0.0, "").replace("radius_m = 0.2\n", "radius_m = 1e-6\nhalf_track_m = 0.2\n");
    let far = format!("[[arena.circles]]\nname = \"c\"\nx_m = 1e6\ny_m = 1e6\nradius_m = 1e-6\n{flea}");
    for picture in [drawing(&tiny), drawing(&far)] {
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
        let document = Document::parse(&picture).unwrap();
        let attributes = document.descendants().flat_map(|node| node.attributes());
        for attribute in
            attributes.filter(|a| ["d", "x", "y", "cx", "cy", "r", "viewBox"].contains(&a.name()))
        {
            let numbers = attribute.value().split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'));
            for number in numbers.filter(|number| !number.is_empty()) {
                assert!(number.parse::<f64>().unwrap().abs() <= 1e7, "{}: {number}", attribute.name());
            }
        }
    }
}

#[test]
fn names_cannot_break_the_picture() {
    let name = "a</title><script>&\\\"";
    let picture = drawing(&format!("name = \"{name}\"\ndescription = \"{name}\\u0001]]>\""));
    let texts = texts(&picture);
    assert!(texts.contains("a</title><script>&\", seen from above"), "{texts}");
    assert!(texts.contains("a</title><script>&\"\u{fffd}]]>"), "{texts}");
    assert!(!picture.contains("<script>"));
}

#[test]
fn an_empty_world_has_a_picture() {
    assert!(texts(&drawing("")).contains("label"));
    let alone = drawing(&robot("alice", 0.0, ""));
    assert!(texts(&alone).contains("alice"));
    let document = Document::parse(&alone).unwrap();
    let width: f64 = document.root_element().attribute("width").unwrap().parse().unwrap();
    assert!((600.0..1200.0).contains(&width), "{width}");
}

#[test]
fn a_thousand_robots_fit_into_a_megabyte() {
    let sensor = |name: &str, bearing: f64| {
        format!(
            "[robots.sensors.{name}]\nkind = \"ir\"\nbearing_rad = {bearing:?}\nrays = 5\nopening_rad = 0.5\n\
             range_m = 1.0\nc1_m2 = 0.03\nc2 = 0.1\n"
        )
    };
    let sensors = sensor("left", 0.8) + &sensor("front", 0.0) + &sensor("right", -0.8);
    let one = |i: usize| {
        let start = format!("start.y_m = {}.0", i / 32);
        robot(&format!("r{i}"), (i % 32) as f64, &start) + &sensors
    };
    let picture = drawing(&(0..1000).map(one).collect::<String>());
    assert!(picture.len() < 1_000_000, "{}", picture.len());
    let texts = texts(&picture);
    assert!(texts.contains("robot r999: 3 sensors") && texts.contains("r0 and 999 more like it"));
}

#[test]
fn a_laser_is_an_area_with_few_corners_and_no_rays() {
    let laser = "[robots.sensors.laser]\nkind = \"laser\"\nmount = {}\nopening_rad = 4.19\nrays = 682\nrange_m = 4.0\n\
                 port.link = { kind = \"uart\", baud = 115200 }\nclock.period_ms = 100.0\n";
    let room = "[[arena.polygons]]\nname = \"room\"\nsolid = false\npoints_m = [[-3, -3], [3, -3], [3, 3], [-3, 3]]\n";
    let picture = drawing(&(room.to_owned() + &robot("r", 0.0, "") + laser));
    assert!(picture.len() < 20_000, "{}", picture.len());
    assert!(texts(&picture).contains("r.laser: laser, range 4 m, 682 rays, every 100 ms"));
}

#[test]
fn a_fan_ends_where_the_ray_does() {
    let wall = "[[arena.circles]]\nname = \"pillar\"\nx_m = 1.0\ny_m = 0.0\nradius_m = 0.3\n";
    let whisker = "[robots.sensors.feeler]\nkind = \"whisker\"\nbearing_rad = 0.0\nlength_m = 2.0\n";
    let world = World::new(Arc::new(
        baudbot_scenario::parse(&(wall.to_owned() + &robot("r", 0.0, "") + whisker)).unwrap(),
    ));
    let view = View { world: extent::of(world.scenario()), scale: 100.0, left: 0.0, top: 0.0 };
    let mut canvas = Canvas::default();
    let caster = RayCaster::new(&world);
    senses::mounts(&mut canvas, &view, &caster, (0, &world.scenario().robots[0]));
    let (start, end) = (view.at([0.2, 0.0].into()), view.at([0.7, 0.0].into()));
    let line = path([start, end]);
    let drawn = canvas.into_text();
    assert!(drawn.contains(&line), "{line} is not in {drawn}");
}

#[test]
fn robots_of_too_many_kinds_are_not_hidden() {
    let robots = |n: usize| -> String {
        let more = |i: usize| format!("actuators.horn = {{ kind = \"speaker\", level = {}.0 }}", i + 1);
        (0..n).map(|i| robot(&format!("r{i}"), i as f64, &more(i))).collect()
    };
    let told = |n: usize| texts(&drawing(&robots(n))).contains("robots of other kinds");
    assert_eq!([told(4), told(5)], [false, true]);
}

/// The pictures in the documents are what the program draws.
#[test]
fn the_documents_have_the_pictures_of_today() {
    let khepera = include_str!("../../../../catalogue/scenarios/khepera.toml");
    let wander = include_str!("../../../../catalogue/scenarios/wander.toml");
    let pictures = [
        ("khepera", khepera, include_str!("../../../../docs/pictures/khepera.svg")),
        ("wander", wander, include_str!("../../../../docs/pictures/wander.svg")),
    ];
    for (name, toml, there) in pictures {
        let is = draw(&baudbot_scenario::parse(toml).unwrap(), name);
        assert!(is.len() < 100_000, "{name}: {}", is.len());
        assert!(
            is == there,
            "docs/pictures/{name}.svg is not what the program draws; look at the new one, which this makes:\n\
             cargo run -- check {name} --svg docs/pictures/{name}.svg"
        );
    }
}

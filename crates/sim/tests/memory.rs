//! The memory of worlds and scenarios is the sum of an allocator's requests, on a test's own thread.

use std::sync::Arc;

use baudbot_sim::World;

/// The tolerance of a count against the allocations.
const TOLERANCE: f64 = 0.16;

/// The bytes that are allocated for a value and kept.
fn allocated<T>(make: impl FnOnce() -> T) -> (T, f64) {
    let mut made = None;
    let found = allocation_counter::measure(|| made = Some(make()));
    (made.unwrap(), found.bytes_current as f64)
}

fn compare(what: &str, counted: usize, allocated: f64, wrong: &mut Vec<String>) {
    let ratio = counted as f64 / allocated;
    let text = format!("{what}: {counted} bytes are counted, {allocated} allocated, {ratio:.2}");
    println!("{text}");
    if (ratio - 1.0).abs() > TOLERANCE {
        wrong.push(text);
    }
}

fn check(what: &str, toml: &str, wrong: &mut Vec<String>) {
    let (scenario, bytes) = allocated(|| Box::new(baudbot_scenario::parse(toml).unwrap()));
    compare(&format!("{what}: scenario"), scenario.memory_bytes(), bytes, wrong);
    let scenario = Arc::new(*scenario);
    let mut world = World::new(Arc::clone(&scenario));
    world.keep_timeline(0);
    let (first, bytes) = allocated(|| Box::new(world.clone()));
    compare(&format!("{what}: state at the start"), first.memory_bytes(), bytes, wrong);
    for _ in 0..300 {
        world.begin();
        world.finish(&[]);
    }
    let (later, bytes) = allocated(|| Box::new(world.clone()));
    compare(&format!("{what}: state later"), later.memory_bytes(), bytes, wrong);
    let (_running, bytes) = allocated(|| {
        let mut world = Box::new(World::new(scenario));
        world.keep_timeline(0);
        for _ in 0..300 {
            world.begin();
            world.finish(&[]);
        }
        world
    });
    println!("{what}: running world {bytes}");
}

#[test]
fn the_memory_of_timelines_is_counted_as_if_they_were_full() {
    let toml = include_str!("../../../catalogue/scenarios/wander.toml");
    let mut world = World::new(Arc::new(baudbot_scenario::parse(toml).unwrap()));
    world.keep_timeline(256);
    let before = world.memory_bytes();
    for _ in 0..1000 {
        world.begin();
        world.finish(&[]);
    }
    assert_eq!(world.robot(0).timeline().events().count(), 256);
    let (copy, bytes) = allocated(|| Box::new(world.clone()));
    let mut wrong = Vec::new();
    compare("wander with its timeline", copy.memory_bytes(), bytes, &mut wrong);
    compare("wander before it began", before, bytes, &mut wrong);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn folder(path: &str) -> Vec<(String, String)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path);
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut scenarios: Vec<_> = files
        .filter(|file| file.extension().is_some_and(|end| end == "toml"))
        .map(|file| (file.display().to_string(), std::fs::read_to_string(&file).unwrap()))
        .collect();
    scenarios.sort();
    scenarios
}

#[test]
fn the_memory_of_every_scenario_and_its_world_is_counted() {
    let (mut n, mut wrong) = (0, Vec::new());
    for (name, toml) in [folder("catalogue/scenarios"), folder("catalogue/scenarios/devices")].concat() {
        // Maps and programs are for the import.
        if baudbot_scenario::parse(&toml).is_ok() {
            check(&name, &toml, &mut wrong);
            n += 1;
        }
    }
    assert!(n > 30, "{n} scenarios");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_memory_of_large_scenarios_is_counted() {
    use std::fmt::Write as _;
    let mut wrong = Vec::new();
    let mut walls = String::from("name = \"walls\"\n");
    for i in 0..20_000 {
        let (x, y) = (f64::from(i % 150), f64::from(i / 150));
        let _ = write!(
            walls,
            "[[arena.polygons]]\nname = \"p{i}\"\npoints_m = [[{x:?}, {y:?}], [{x:?}5, {y:?}], [{x:?}5, {y:?}5]]\n"
        );
    }
    check("walls", &walls, &mut wrong);
    let wander = include_str!("../../../catalogue/scenarios/wander.toml");
    let (_, robot) = wander.split_once("[[robots]]").unwrap();
    let mut crowd = String::from("name = \"crowd\"\n");
    for i in 0..500 {
        let place = format!("start = {{ x_m = {}.0, y_m = {}.0, heading_rad = 0.0 }}", i % 50, i / 50);
        let own = robot
            .replace("name = \"robot\"", &format!("name = \"r{i}\""))
            .replace("start = { x_m = -0.2, y_m = 0.0, heading_rad = 0.0 }", &place);
        crowd += &format!("[[robots]]{own}");
    }
    check("crowd", &crowd, &mut wrong);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

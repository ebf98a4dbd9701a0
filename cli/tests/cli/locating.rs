//! `baudbot locate`.

use std::fs;

use roxmltree::Document;
use serde_json::Value;

use crate::cli::{baudbot, good, place};

const OFFICE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/tour.toml");

/// The pose in the office, as programs get it.
fn found(more: &[&str]) -> Value {
    serde_json::from_str(&good(&[&["locate", OFFICE, "--json"], more].concat())).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn a_wrong_guess_is_mended_by_every_method() {
    let guess = ["--guess", "2.3,1.8,0.2"];
    for (more, most_m, most_rad) in [
        (&["--threshold", "0", "--iterations", "1000"][..], 0.03, 0.01),
        (&["--threshold", "0", "--iterations", "1000", "--shrink"], 0.015, 0.005),
        (&["--method", "refine"], 0.01, 0.003),
    ] {
        for seed in ["1", "2", "3"] {
            let found = found(&[&guess[..], more, &["--seed", seed]].concat());
            let (m, rad) = (number(&found["off_m"]), number(&found["off_rad"]));
            assert!(m < most_m && rad < most_rad, "{more:?}, seed {seed}: {m} m, {rad} rad");
            let at = |axis: &str| number(&found["found"][axis]) - number(&found["truth"][axis]);
            assert!((at("x_m").hypot(at("y_m")) - m).abs() < 1e-12, "{found}");
            // The map is the arena, so what is left is the noise of the laser.
            let error = number(&found["error_at_truth"]);
            assert!((0.003..0.006).contains(&error), "{error}");
        }
    }
}

/// The first pose that was tried is the guess; those at which the search went on are ever better, and each is within the
/// box around the one before.
#[test]
fn the_poses_are_those_of_the_search() {
    let found =
        found(&["--guess", "2.3,1.8,0.2", "--box-m", "0.2", "--threshold", "0", "--iterations", "200"]);
    let tried = found["tried"].as_array().unwrap();
    assert_eq!((tried.len(), found["poses_tried"].as_u64()), (201, Some(201)));
    let pose = |tried: &Value| ["x_m", "y_m", "heading_rad"].map(|axis| number(&tried[axis]));
    assert_eq!(pose(&tried[0]), [2.3, 1.8, 0.2]);
    let (mut best, mut accepted) = (&tried[0], 0);
    for next in tried {
        let is_first = accepted == 0;
        assert_eq!(next["accepted"], is_first || number(&next["error"]) < number(&best["error"]), "{next}");
        let [off_x, off_y, turn] = std::array::from_fn(|i| (pose(next)[i] - pose(best)[i]).abs());
        assert!(off_x <= 0.1 && off_y <= 0.1 && turn <= 0.05 + 1e-12, "{next} is outside the box of {best}");
        if next["accepted"] == true {
            best = next;
            accepted += 1;
        }
    }
    assert_eq!((found["poses_accepted"].as_u64(), pose(best)), (Some(accepted), pose(&found["found"])));
    assert_eq!(best["error"], found["error"]);
}

#[test]
fn the_table_is_of_the_poses_that_were_accepted() {
    let args = ["--guess", "2.3,1.8,0.2", "--iterations", "100"];
    let (said, found) = (good(&[&["locate", OFFICE], &args[..]].concat()), found(&args));
    let (tried, accepted) =
        (found["poses_tried"].as_u64().unwrap(), found["poses_accepted"].as_u64().unwrap());
    assert!(said.contains(&format!("tried   {tried} poses, {accepted} accepted\n")), "{said}");
    assert!(said.contains("\nguess   (2.3, 1.8), 0.2 rad; 0.361 m and 0.200 rad off; ε "), "{said}");
    let rows: Vec<Vec<&str>> = said
        .lines()
        .skip_while(|line| !line.starts_with("pose"))
        .skip(1)
        .map(|line| line.split_whitespace().collect())
        .collect();
    assert_eq!(rows.len() as u64, accepted, "{said}");
    for row in rows {
        let tried = &found["tried"][row[0].parse::<usize>().unwrap()];
        assert_eq!(tried["accepted"], true, "{row:?}");
        assert_eq!(row[1], format!("{:.4}", number(&tried["error"])), "{row:?}");
        assert_eq!(row[2], format!("{:.3}", number(&tried["x_m"])), "{row:?}");
    }
}

#[test]
fn a_picture_has_each_pose_that_was_tried() {
    let path = place("poses.svg");
    let args = ["locate", OFFICE, "--guess", "2.3,1.8,0.2", "--threshold", "0"];
    let said = good(&[&args[..], &["--svg", path.to_str().unwrap()]].concat());
    assert_eq!(said, good(&args));
    let picture = fs::read_to_string(&path).unwrap();
    assert_eq!(good(&[&args[..], &["--svg", "-"]].concat()), picture);
    let found = found(&["--guess", "2.3,1.8,0.2", "--threshold", "0"]);
    let (tried, accepted) =
        (number(&found["poses_tried"]) as usize, number(&found["poses_accepted"]) as usize);
    let document = Document::parse(&picture).unwrap();
    let all = |class: &'static str| {
        document.descendants().filter(move |node| node.attribute("class") == Some(class)).collect::<Vec<_>>()
    };
    let marks = |class, mark| {
        all(class).iter().map(|node| node.attribute("d").unwrap().matches(mark).count()).collect::<Vec<_>>()
    };
    // A line and a head for each that was no better; a corner of the way for each other.
    assert_eq!(marks("rejected", 'Z'), [tried - accepted], "{picture}");
    assert_eq!(marks("attempt", 'L'), [accepted - 1; 2], "the plan and the enlarged part");
    assert_eq!(all("accepted").len(), accepted);
    // All rays that met something, from both poses, in the plan.
    let rays = number(&found["rays"]) as usize;
    for class in ["seen-from-guess", "seen-from-found"] {
        assert!((rays / 2..=rays).contains(&marks(class, 'M')[0]), "{class}: {:?}", marks(class, 'M'));
    }
    for class in ["truth", "guess", "found"] {
        assert_eq!(all(class).len(), 2, "{class}");
    }
    let title = all("truth")[0].descendants().find(|node| node.has_tag_name("title")).unwrap().text();
    assert_eq!(title, Some("where the robot is: (2.000, 2.000), 0.000 rad"));
}

#[test]
fn the_robot_is_where_it_is_put_and_looks_with_the_sensors_noise() {
    let there = ["--at", "6,3,1.5", "--guess", "5.9,3.1,1.45"];
    let (noisy, exact) = (found(&there), found(&[&there[..], &["--no-noise"]].concat()));
    assert_eq!([&noisy["truth"]["x_m"], &noisy["truth"]["heading_rad"]].map(number), [6.0, 1.5]);
    assert!(number(&noisy["error_at_truth"]) > 0.003, "{}", noisy["error_at_truth"]);
    assert!(number(&exact["error_at_truth"]) < 1e-9, "{}", exact["error_at_truth"]);
    assert_ne!(noisy["error"], exact["error"]);
    let other = found(&[&there[..], &["--seed", "2"]].concat());
    assert_ne!(noisy["error_at_truth"], other["error_at_truth"]);
    assert_eq!(noisy, found(&there), "the same seed, the same search");
}

/// Walls that are lower than the laser are not sensed and are no part of the map; robots are sensed, and are no part of
/// it either.
#[test]
fn the_map_is_what_is_as_high_as_the_laser() {
    let path = place("low.toml");
    let body = "{ radius_m = 0.1, height_m = 0.5, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }";
    let urg = "{ preset = \"urg-04lx\", mount = {}, height_m = 0.3 }";
    let write = |height_m: f64| {
        let low = format!(
            "[[arena.polygons]]\nname = \"border\"\nsolid = false\nheight_m = {height_m:?}\n\
             points_m = [[0, 0], [3, 0], [3, 2], [0, 2]]\n\
             [[robots]]\nname = \"eve\"\nstart = {{ x_m = 2.0, y_m = 1.0 }}\nbody = {body}\n\
             [[robots]]\nname = \"bob\"\nstart = {{ x_m = 1.0, y_m = 1.0 }}\nbody = {body}\nsensors.urg = {urg}\n"
        );
        fs::write(&path, low).unwrap();
        baudbot(&["locate", path.to_str().unwrap(), "--guess", "1.05,1,0", "--threshold", "0", "--json"])
    };
    let (code, _, err) = write(0.2);
    assert_eq!(code, 2);
    assert!(err.contains("nothing in the scenario's arena is as high as the laser `urg`, 0.3 m"), "{err}");
    let (code, out, err) = write(0.4);
    assert_eq!((code, err.as_str()), (0, ""));
    let found: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(found["robot"], "bob");
    // Eve, who is not in the map, is worth more than the noise.
    assert!(number(&found["error_at_truth"]) > 0.05, "{}", found["error_at_truth"]);
}

/// In the open nothing is near enough for a laser of 4 m, and there is nothing to compare.
#[test]
fn who_sees_nothing_finds_nothing_and_ends_with_1() {
    let path = place("hangar.toml");
    let body = "{ radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }";
    let hangar = format!(
        "[[arena.polygons]]\nname = \"hangar\"\nsolid = false\npoints_m = [[0, 0], [40, 0], [40, 40], [0, 40]]\n\
         [[robots]]\nname = \"bob\"\nstart = {{ x_m = 20.0, y_m = 20.0 }}\nbody = {body}\n\
         sensors.urg = {{ preset = \"urg-04lx\", mount = {{}} }}\n"
    );
    fs::write(&path, hangar).unwrap();
    let (code, out, err) = baudbot(&["locate", path.to_str().unwrap(), "--guess", "20.1,20,0"]);
    assert_eq!(code, 1, "{out}");
    assert!(
        err.starts_with("error: too few rays could be compared with the map at every pose that was tried"),
        "{err}"
    );
    assert!(out.contains("tried   301 poses, 1 accepted\n") && out.contains("rad off; ε —\n"), "{out}");
}

#[test]
fn what_cannot_be_is_refused_with_its_option() {
    let refusal_of = |scenario: &str, args: &[&str]| {
        let (code, out, err) = baudbot(&[&["locate", scenario], args].concat());
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        err
    };
    let refusal = |args: &[&str]| refusal_of(OFFICE, &[&["--guess", "2,2,0"], args].concat());
    let wall = refusal(&["--at", "1.5,7,0"]);
    assert_eq!(wall, "error: --at: no room: `shelf` is in the way; choose another place\n");
    let start = refusal(&["--set", "robots.robot.start.x_m=0.3", "--at", "2e6,0,0"]);
    assert!(start.contains("must be x, y and heading with commas between them"), "{start}");
    assert!(
        refusal_of(OFFICE, &["--guess", "2,2"])
            .contains("in metres and radians, such as 1.5,-2,0.1; is `2,2`")
    );
    assert!(refusal_of(OFFICE, &[]).contains("--guess <X,Y,RAD>"));
    assert!(refusal(&["--robot", "eve"]).contains("--robot: there is no robot `eve`; there are: robot"));
    assert!(refusal(&["--laser", "eye"]).contains("--laser: `robot` has no laser `eye`; it has: laser"));
    assert!(refusal(&["--method", "magic"]).contains("search, refine"));
    assert!(refusal(&["--box-m", "0"]).contains("--box-m: must be above 0 and at most 100, is 0"));
    assert!(refusal(&["--threshold", "-1"]).contains("--threshold: must be 0 or more, is -1"));
    assert!(refusal(&["--iterations", "0"]).contains("must be from 1 to 100000, is 0"));
    assert!(refusal(&["--rays", "0"]).contains("must be from 1 to 100000, is 0"));
    let strange = refusal(&["--method", "refine", "--shrink"]);
    assert_eq!(strange, "error: --shrink: belongs to --method search; leave it out, or use that method\n");
    assert!(refusal(&["--starts", "3"]).contains("--starts: belongs to --method refine"));
    let refine = refusal(&["--method", "refine", "--sd-m", "-0.1"]);
    assert!(refine.contains("--sd-m: must be above 0 and at most 100, is -0.1"), "{refine}");
    let blind = refusal_of("wander", &["--guess", "0,0,0"]);
    assert!(
        blind.contains("no robot of the scenario has a laser; give it a sensor of kind \"laser\""),
        "{blind}"
    );
    let named = refusal_of("wander", &["--guess", "0,0,0", "--robot", "robot"]);
    assert!(named.contains("--robot: `robot` has no laser"), "{named}");
    // A sweep takes 67 ms.
    let over = refusal(&["--set", "end.after_s=0.01"]);
    assert!(
        over.contains("the laser `laser` takes no scan within 60 s") && over.contains("scenario end before"),
        "{over}"
    );
}

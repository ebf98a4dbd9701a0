//! The writes of each brain of the catalogue, compared with its statement.

use baudbot_brains::catalogue::catalogue;
use baudbot_sim::Scenario;
use baudbot_sim::model::Writes;
use baudbot_sim::robot::Exceptions;

use baudbot_run::assignment::{Assigned, Assignment};
use baudbot_run::in_process;

/// A robot that any brain of the catalogue can drive, on its cable.
fn robot(cable: &str) -> String {
    let eye = |name: &str, bearing_rad: f64| {
        format!(
            "[robots.sensors.{name}]\nkind = \"ir\"\nbearing_rad = {bearing_rad}\nrays = 3\nopening_rad = 0.3\nrange_m = 0.8\n\
             c1_m2 = 0.03\nc2 = 0.1\nbits = 8\nperiod_ms = 20.0\n"
        )
    };
    let eyes = [
        ("ir_left", 0.8),
        ("ir_front_left", 0.4),
        ("ir_front", 0.0),
        ("ir_front_right", -0.4),
        ("ir_right", -0.8),
        ("eye", 0.0),
        ("ahead", 0.0),
        ("left", 0.4),
        ("right", -0.4),
        ("left_ear", 0.8),
        ("right_ear", -0.8),
        ("eye_left", 0.4),
        ("eye_right", -0.4),
    ];
    let eyes: String = eyes.into_iter().map(|(name, bearing_rad)| eye(name, bearing_rad)).collect();
    format!(
        "step_ms = 10.0\nend.after_s = 15.0\n\
         [[arena.polygons]]\nname = \"wall\"\nsolid = false\npoints_m = [[-3, -3], [3, -3], [3, 3], [-3, 3]]\n\
         [[arena.fields]]\nname = \"smell\"\nsources = [{{ x_m = 1.0, y_m = 1.0, strength = 1.0, width_m = 2.0 }}]\n\
         [[arena.fields]]\nname = \"lure\"\ntrail = {{ corner_m = [-3.0, -3.0], size_m = [6.0, 6.0], cell_m = 0.2, decay_s = 60.0 }}\n\
         [[robots]]\nname = \"r\"\n\
         body = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1, damping_n_s_m = 15.0, turn_damping_nm_s = 0.78 }}\n\
         motors = {{ signal_bits = 8 }}\n{cable}\n\
         battery = {{ nominal_v = 12.0, capacity_mah = 1200.0 }}\n{eyes}\
         [robots.actuators.call]\nkind = \"speaker\"\nlevel = 1.0\n\
         [robots.actuators.gland]\nkind = \"dispenser\"\nfield = \"lure\"\nrate_per_s = 0.02\n\
         [robots.sensors.odometer]\nkind = \"odometer\"\nperiod_ms = 20.0\n\
         [robots.sensors.gauge]\nkind = \"battery\"\nperiod_ms = 100.0\n\
         [robots.sensors.nose]\nkind = \"field\"\nfield = \"smell\"\nmount = {{ x_m = 0.0 }}\nperiod_ms = 50.0\n\
         [robots.sensors.food]\nkind = \"field\"\nfield = \"smell\"\nmount = {{ x_m = 0.0 }}\nperiod_ms = 50.0\n\
         [robots.sensors.water]\nkind = \"field\"\nfield = \"smell\"\nmount = {{ x_m = 0.0 }}\nperiod_ms = 50.0\n\
         [robots.sensors.nest]\nkind = \"field\"\nfield = \"smell\"\nmount = {{ x_m = 0.0 }}\nperiod_ms = 50.0\n\
         [robots.sensors.antenna_left]\nkind = \"field\"\nfield = \"lure\"\nmount = {{ y_m = 0.04 }}\nperiod_ms = 50.0\n\
         [robots.sensors.antenna_right]\nkind = \"field\"\nfield = \"lure\"\nmount = {{ y_m = -0.04 }}\nperiod_ms = 50.0\n\
         [robots.sensors.bumper]\nkind = \"bumper\"\nbearing_rad = 0.0\nopening_rad = 1.6\nrays = 5\ntravel_m = 0.01\nperiod_ms = 50.0\n\
         [robots.sensors.hair]\nkind = \"whisker\"\nmount = {{ x_m = 0.2 }}\nlength_m = 0.2\nperiod_ms = 20.0\n\
         [robots.actuators.leg]\nkind = \"turret\"\nmin_rad = 0.0\nmax_rad = 1.5\nrate_rad_s = 6.0\n\
         [robots.sensors.camera]\nkind = \"line-camera\"\nbearing_rad = 0.0\nheight_m = 0.05\nopening_rad = 0.4\ncolumns = 8\nrange_m = 2.0\nperiod_ms = 40.0\n\
         [robots.sensors.laser]\nkind = \"laser\"\nmount = {{ x_m = 0.0 }}\nrays = 61\nopening_rad = 4.0\nrange_m = 5.0\nperiod_ms = 100.0\n\
         port = {{ link = {{ kind = \"uart\", baud = 115200 }} }}\n"
    )
}

/// Fast, slow and very slow; streamed and asked; without a cable.
const CABLES: [&str; 6] = [
    "link = { kind = \"uart\", baud = 115200 }\nfirmware = { mode = \"stream\", period_ms = 20.0, phase_ms = 3.0 }",
    "link = { kind = \"uart\", baud = 9600 }\nfirmware = { mode = \"stream\", period_ms = 50.0, phase_ms = 3.0 }",
    "link = { kind = \"uart\", baud = 1200 }\nfirmware = { mode = \"stream\", period_ms = 100.0, phase_ms = 3.0 }",
    "link = { kind = \"uart\", baud = 19200, half_duplex = true }\nfirmware = { mode = \"poll\" }",
    "link = { kind = \"uart\", baud = 2400, adapter = { kind = \"ftdi\" } }\nfirmware = { mode = \"poll\" }",
    "link = { kind = \"ideal\" }",
];

fn scenario(cable: &str) -> Scenario {
    let toml = robot(cable);
    baudbot_scenario::parse(&toml).unwrap_or_else(|error| panic!("{error}\n{toml}"))
}

/// The writes of a brain beyond its statement; `stated` takes the place of that.
fn exceptions(brain: &str, cable: &str, stated: Option<Writes>) -> Exceptions {
    let assignment = Assignment { brain: brain.to_owned(), robots: vec!["r".to_owned()] };
    let assigned = Assigned { brains: vec![assignment.clone()], ..Assigned::default() };
    let mut scenario = scenario(cable);
    if let Some(writes) = stated {
        std::sync::Arc::make_mut(&mut scenario.robots[0].model).writes = Some(writes);
    }
    assigned.state_writes(&mut scenario.robots).unwrap();
    let world =
        in_process::run(scenario, &[assignment], |_| {}).unwrap_or_else(|error| panic!("{brain}: {error}"));
    world.robot(0).cycles().exceptions
}

#[test]
fn each_brain_of_the_catalogue_writes_when_it_says() {
    for entry in catalogue() {
        for cable in CABLES {
            let found = exceptions(entry.name, cable, None);
            assert_eq!(found, Exceptions::default(), "{}, {}, {cable}", entry.name, entry.writes);
        }
    }
}

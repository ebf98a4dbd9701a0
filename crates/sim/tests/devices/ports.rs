//! Devices with a cable of their own, past the microcontroller.

use std::f64::consts::TAU;

use baudbot_sim::World;
use baudbot_wire::{line_image, nmea, scip};

use crate::common::{run, world};
use crate::devices::scene::{block, named, scene, view, wall};

/// The microcontroller sends nothing by itself, so that the brain steps when something has come through a port.
const POLLED: &str = "firmware = { mode = \"poll\" }";

/// An URG-04LX: 682 of 1024 steps, ten scans a second.
fn urg(link: &str, more: &str) -> String {
    let opening = TAU * 681.0 / 1024.0;
    let laser = format!(
        "kind = \"laser\"\nmount = {{}}\nopening_rad = {opening}\nrays = 682\nmin_m = 0.02\nrange_m = 4.0\nsweep_ms = 66.6\n\
         clock = {{ period_ms = 100.0, phase_ms = 0.0 }}\nport = {{ link = {link}, first_step = 44{more} }}"
    );
    let walls = wall(1.5) + &block("left", [-3.0, 2.0, 1.0, 2.1], "");
    scene(&walls, POLLED, &named("s", &laser))
}

fn uart(baud: u32) -> String {
    format!("{{ kind = \"uart\", baud = {baud} }}")
}

/// All bytes of the only port, in so many ticks.
fn listen(world: &mut World, ticks: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    for _ in 0..ticks {
        world.begin();
        bytes.extend(world.robot(0).unread_of_ports().next().unwrap().1);
        world.finish(&[]);
    }
    bytes
}

#[test]
fn a_scan_of_a_urg_04lx_is_a_message_of_2137_bytes() {
    let mut world = world(&urg(&uart(750_000), ""));
    let bytes = listen(&mut world, 20);
    let end = scip::message_end(&bytes).expect("a message");
    assert_eq!(end, 2137);
    let scan = scip::parse(&bytes[..end]).unwrap();
    assert_eq!((scan.time_ms, scan.format.first_step, scan.format.last_step), (0, 44, 725));
    let truth = view(&world, "s").sample;
    assert_eq!(truth.len(), 682);
    for (i, (told, &truth)) in scan.ranges_mm().zip(truth).enumerate() {
        match told {
            Some(mm) => assert!((f64::from(mm) - truth * 1e3).abs() <= 0.5 + 1e-9, "{i}: {mm} and {truth}"),
            None => assert_eq!(truth, -1.0, "{i}"),
        }
    }
    assert!(truth.contains(&-1.0) && truth[341] > 1.49);
    let reading = &world.robot(0).readings()[0];
    assert_eq!(reading.values.len(), 682);
    assert_eq!(reading.sampled_at.map(|at| at.as_ns() % 100_000_000), Some(0));
}

#[test]
fn two_characters_a_value_make_it_1435_bytes() {
    let mut world = world(&urg(&uart(750_000), ", characters = 2"));
    let bytes = listen(&mut world, 20);
    assert_eq!(scip::message_end(&bytes), Some(1435));
}

#[test]
fn a_fast_cable_carries_ten_scans_a_second_and_a_slow_one_every_second() {
    let scans = |baud: u32| {
        let mut world = world(&urg(&uart(baud), ""));
        let bytes = listen(&mut world, 1001);
        let port = *world.robot(0).port(0).unwrap();
        // Bytes that arrive after the brain's step in the last tick have not been given to it.
        assert!(port.bytes - bytes.len() as u64 <= 750, "{port:?}");
        assert_eq!((port.bad_frames, port.messages), (0, port.bytes / 2137));
        (port.messages, view(&world, "s").samples, view(&world, "s").missed)
    };
    // Scans are ready at 66.6, 166.6, … ms; 2137 characters take 28.5 ms, or 185.5 ms.
    assert_eq!(scans(750_000), (100, 100, 0));
    let (arrived, taken, missed) = scans(115_200);
    assert_eq!((taken, missed), (100, 50));
    assert!((49..=50).contains(&arrived), "{arrived}");
}

#[test]
fn a_scan_is_as_old_as_its_sweep_and_its_way() {
    let mut world = world(&urg(&uart(115_200), ""));
    listen(&mut world, 1000);
    let freshness = view(&world, "s").freshness;
    let way_ns = 2137 * 10 * 1_000_000_000_u64 / 115_200 + 1;
    assert_eq!(freshness.ages.max_ns().unwrap(), 66_600_000 + way_ns);
    assert_eq!(freshness.ages.sum_ns(), freshness.ages.max_ns().unwrap() * freshness.ages.count());
}

#[test]
fn an_ideal_cable_takes_no_time() {
    let mut world = world(&urg("{ kind = \"ideal\" }", ""));
    listen(&mut world, 100);
    assert_eq!(view(&world, "s").freshness.ages.max_ns().unwrap(), 66_600_000);
    assert_eq!(world.robot(0).port(0).unwrap().messages, 10);
}

#[test]
fn bad_bytes_on_a_port_are_counted_and_the_next_message_is_whole() {
    let mut world = world(&urg("{ kind = \"uart\", baud = 750000, byte_error_rate = 0.0002 }", ""));
    run(&mut world, 2000, 0.0, 0.0);
    let port = world.robot(0).port(0).unwrap();
    // The sound part of 200 scans is 0.9998^2137 = 0.65.
    assert!((110..=150).contains(&port.messages), "{port:?}");
    assert!(port.bad_frames > 40 && port.corrupted_bytes > 50, "{port:?}");
}

#[test]
fn a_cable_on_which_every_byte_is_wrong_gives_up_message_after_message() {
    for sensor in ["gps", "laser"] {
        let link = "{ kind = \"uart\", baud = 1000000, byte_error_rate = 1.0 }";
        let toml = if sensor == "laser" {
            urg(link, "")
        } else {
            scene(
                "",
                POLLED,
                &named("s", &format!("kind = \"gps\"\nperiod_ms = 20.0\nport = {{ link = {link} }}")),
            )
        };
        let mut world = world(&toml);
        run(&mut world, 1000, 0.0, 0.0);
        let port = world.robot(0).port(0).unwrap();
        assert_eq!(port.messages, 0, "{port:?}");
        assert!(port.bad_frames >= 40, "what is no message must not be kept: {port:?}");
    }
}

fn gps(top: &str, more: &str) -> World {
    let top = format!("{top}\n[arena]\nlatitude_deg = 57.7\nlongitude_deg = 11.97\n");
    let port = format!("port = {{ link = {}{more} }}", uart(4800));
    let start = format!("start = {{ x_m = 3.0, y_m = -4.0, heading_rad = 1.0 }}\n{POLLED}");
    world(&scene(&top, &start, &named("s", &format!("kind = \"gps\"\nperiod_ms = 1000.0\n{port}"))))
}

#[test]
fn a_receivers_sentences_arrive_most_of_a_second_late_at_4800_baud() {
    let mut world = gps("", "");
    let bytes = listen(&mut world, 1000);
    let port = *world.robot(0).port(0).unwrap();
    assert_eq!(port.messages, 10, "one fix a second");
    let length = bytes.len() / 10;
    let freshness = view(&world, "s").freshness;
    let age_s = freshness.ages.max_ns().unwrap() as f64 * 1e-9;
    assert!((age_s - length as f64 / 480.0).abs() < 1e-6, "{age_s} s, {length} bytes");
    assert!((0.78..0.95).contains(&age_s), "{age_s}");
    assert_eq!((freshness.readable, freshness.ages.count()), (10, 10));
}

#[test]
fn an_rmc_alone_is_a_sixth_of_a_second() {
    let mut world = gps("", ", sentences = \"rmc\"");
    run(&mut world, 300, 0.0, 0.0);
    let age_s = view(&world, "s").freshness.ages.max_ns().unwrap() as f64 * 1e-9;
    assert!((0.13..0.17).contains(&age_s), "{age_s}");
}

#[test]
fn a_fix_comes_through_its_sentences_to_a_fifth_of_a_metre() {
    let mut world = gps("", "");
    let bytes = listen(&mut world, 100);
    let reading = &world.robot(0).readings()[0].values;
    let metres = 6_371_008.8 * std::f64::consts::PI / 180.0;
    let (north, east) =
        ((reading[0] - 57.7) * metres, (reading[1] - 11.97) * metres * 57.7_f64.to_radians().cos());
    assert!((north + 4.0).abs() < 0.2 && (east - 3.0).abs() < 0.2, "{north} {east}");
    assert_eq!(reading[2], 1.0);
    let kinds: Vec<_> = bytes
        .split_inclusive(|&b| b == b'\n')
        .map(|line| String::from_utf8_lossy(&line[1..6]).into_owned())
        .collect();
    assert_eq!(kinds, ["GPGGA", "GPGSA", "GPGSV", "GPGSV", "GPGSV", "GPRMC"]);
    // The first of three with the twelve satellites, which are those of even numbers.
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("GPGSV,3,1,12,02,15,000,40,04,21,150,40,06,27,300,40,08,33,090,40*"), "{text}");
}

#[test]
fn altitude_satellites_and_dilution_come_through_their_sentences() {
    let top = "[arena]\nlatitude_deg = 57.7\naltitude_m = 100.0\n[[arena.zones]]\nname = \"street\"\nx_m = 0.0\ny_m = 0.0\n\
               radius_m = 9.0\nhorizon_deg = 50.0\n";
    let sensor =
        format!("kind = \"gps\"\nsatellites = true\nperiod_ms = 1000.0\nport = {{ link = {} }}", uart(4800));
    let mut world = world(&scene(top, POLLED, &named("s", &sensor)));
    let bytes = listen(&mut world, 250);
    let text = String::from_utf8_lossy(&bytes);
    let reading = &world.robot(0).readings()[0].values;
    assert_eq!((reading[2], &reading[5..]), (1.0, &[100.0, 6.0, 2.2][..]), "{text}");
    assert_eq!(world.robot(0).port(0).unwrap().messages, 2, "one reading a second: {text}");
    assert!(text.contains(",1,06,2.20,100.0,M,"), "{text}");
    // The six highest; PDOP is the root of 2.1962² + 6.0196².
    assert!(text.contains("$GPGSA,A,3,14,16,18,20,22,24,,,,,,,6.41,2.20,6.02*"), "{text}");
    assert!(text.contains("GPGSV,3,1,12,02,15,000,,04,21,150,,06,27,300,,08,33,090,*"), "{text}");
}

#[test]
fn without_sky_a_receiver_says_v_and_has_no_fix() {
    let zone = "[[arena.zones]]\nname = \"house\"\nx_m = 3.0\ny_m = -4.0\nradius_m = 1.0\nindoors = true\n";
    let port = format!(
        "kind = \"gps\"\nperiod_ms = 1000.0\nport = {{ link = {}, sentences = \"rmc\" }}",
        uart(4800)
    );
    let mut world = world(&scene(zone, "start = { x_m = 3.0, y_m = -4.0 }", &named("s", &port)));
    let bytes = listen(&mut world, 100);
    let nmea::Sentence::Rmc(rmc) = nmea::parse(&bytes).unwrap() else { panic!("no RMC") };
    assert_eq!(rmc.position, None);
    assert!(String::from_utf8_lossy(&bytes).contains(",V,"));
    assert_eq!(world.robot(0).readings()[0].values[2], 0.0);
}

fn camera(link: &str) -> World {
    let top = block("red", [-0.5, 2.0, 0.5, 2.1], "color = [255, 0, 51]")
        + "[[arena.circles]]\nname = \"green\"\nx_m = 1.5\ny_m = 0.0\nradius_m = 0.5\ncolor = [0, 255, 102]\n";
    let sensor = format!(
        "kind = \"line-camera\"\nmount = {{}}\nopening_rad = 3.141592653589793\ncolumns = 41\nrows = 30\nrange_m = 5.0\n\
         background = [1, 2, 3]\nperiod_ms = 50.0\nport = {{ link = {link} }}"
    );
    world(&scene(&top, POLLED, &named("s", &sensor)))
}

#[test]
fn an_image_has_10_bytes_and_3_a_pixel_and_2_a_column() {
    let mut world = camera(&uart(1_000_000));
    let bytes = listen(&mut world, 100);
    let length = 10 + 41 * (3 * 30 + 2);
    let port = world.robot(0).port(0).unwrap();
    assert_eq!((port.bytes, port.messages, port.bad_frames), (20 * length as u64, 20, 0));
    let image = line_image::parse(&bytes[..length]).unwrap();
    assert_eq!((image.columns, image.rows, image.sequence), (41, 30, 0));
    let columns: Vec<_> = image.columns().collect();
    let seen = |i: usize| (columns[i].rgb, columns[i].depth_mm);
    // From left to right: red 2 m to the left, green 1 m ahead, nothing to the right.
    assert_eq!([seen(0), seen(20), seen(40)], [([255, 0, 51], 2000), ([0, 255, 102], 1000), ([1, 2, 3], 0)]);
    let reading = &world.robot(0).readings()[0].values;
    assert_eq!([reading[0], reading[41 + 20], reading[3 * 41], reading[3 * 41 + 40]], [1.0, 1.0, 2.0, -1.0]);
}

#[test]
fn an_image_of_many_rows_arrives_as_it_was_taken() {
    let red = block("red", [1.0, -3.0, 1.1, 3.0], "color = [255, 0, 51]\nheight_m = 0.3");
    let sensor = format!(
        "kind = \"camera\"\nmount = {{}}\nheight_m = 0.2\nopening_rad = 1.0\ncolumns = 7\nrows = 5\nrange_m = 5.0\n\
         floor = [4, 5, 6]\nbackground = [1, 2, 3]\nperiod_ms = 50.0\nport = {{ link = {} }}",
        uart(1_000_000)
    );
    let mut world = world(&scene(&red, POLLED, &named("s", &sensor)));
    let bytes = listen(&mut world, 10);
    let length = 10 + 7 * (3 * 5 + 2);
    let image = line_image::parse(&bytes[..length]).unwrap();
    assert_eq!((image.columns, image.rows), (7, 5));
    assert_eq!([0, 2, 4].map(|row| image.row(row).unwrap()[3]), [[1, 2, 3], [255, 0, 51], [4, 5, 6]]);
    assert_eq!(world.robot(0).readings()[0].values.as_slice(), view(&world, "s").sample);
}

#[test]
fn images_that_the_cable_cannot_carry_are_left_out() {
    let mut world = camera(&uart(115_200));
    let bytes = listen(&mut world, 1000);
    let port = *world.robot(0).port(0).unwrap();
    // An image takes 328.3 ms: every seventh is sent.
    assert_eq!(view(&world, "s").samples, 200);
    assert_eq!(view(&world, "s").missed, 200 - 29);
    assert!(port.messages >= 28 && port.bytes - bytes.len() as u64 <= 115, "{port:?}");
}

#[test]
fn a_brain_with_a_port_is_woken_by_it() {
    let mut world = camera(&uart(1_000_000));
    assert_eq!(world.begin()[0].at.as_ns(), 10_000_000, "nothing has come, so the tick ends");
    // The image has 3782 bytes, 37.82 ms.
    world.finish(&[]);
    let first = (1..10).find(|_| {
        let arrived = !world.begin().is_empty() && world.robot(0).readings()[0].readable;
        world.finish(&[]);
        arrived
    });
    assert_eq!(first, Some(3));
}

/// The laser of Fig. 1.18 is joined to the laptop.
#[test]
fn a_port_does_not_keep_the_microcontroller_busy() {
    let sensors = named("c", "kind = \"compass\"\nperiod_ms = 1.0");
    let mut world = world(&(urg(&uart(19_200), "") + &sensors));
    run(&mut world, 100, 0.0, 0.0);
    assert_eq!(view(&world, "c").missed, 0);
    assert!(view(&world, "c").samples >= 990);
}

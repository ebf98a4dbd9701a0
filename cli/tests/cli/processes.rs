//! Servers, brains and observers in processes of their own, and `baudbot check`.

use std::time::Duration;

use baudbot_proto::v1;

use crate::cli::{Running, baudbot, good, place};

/// A server on a free port and a Unix socket, and both addresses.
pub(crate) fn serve(socket: &str, args: &[&str]) -> (Running, String, String) {
    let socket = format!("unix:{}", place(socket).display());
    let listen = ["serve", "--listen", "127.0.0.1:0", "--listen", &socket];
    let mut server = Running::start(&[&listen, args].concat());
    let lines = server.lines_until("Ctrl-C");
    let address = |i: usize| lines[i].strip_prefix("listening on ").expect("an address").to_owned();
    assert_eq!(address(1), socket);
    assert!(!address(0).ends_with(":0"));
    let paste = format!("  baudbot brain avoid --connect {} --world wander --robot robot", address(0));
    assert!(lines.contains(&paste), "{lines:?}");
    (server, address(0), socket)
}

#[test]
fn a_brain_in_another_process_drives_a_world_in_lockstep_to_its_end() {
    let lockstep = ["wander", "--pace", "lockstep", "--set", "end.after_s=1.0"];
    let (mut server, tcp, unix) = serve("lockstep.sock", &lockstep);
    let frame = good(&["watch", "--once", "--connect", &tcp]);
    assert!(frame.starts_with("world wander  t = 0.0"), "{frame}");
    let (code, out, err) = baudbot(&["brain", "avoid", "--connect", &unix]);
    assert_eq!((code, err.as_str()), (0, DRIVING));
    // One for each message of 50 a second: in lockstep `avoid` is not asked at the other steps.
    assert_eq!(out, "the run is over after 50 turns\n");
    let end = "note: the run of world wander ended at 1 s because the scenario's time is over; Reset on the page begins it again\n";
    assert_eq!(server.first_complaint(), end);
    server.signal("-TERM");
    assert_eq!(server.end().0, 0);
    assert!(!std::path::Path::new(unix.strip_prefix("unix:").unwrap()).exists());
}

#[test]
fn an_observer_sees_a_world_in_real_time() {
    let (server, tcp, _) = serve("watch.sock", &["wander", "khepera"]);
    let frame = good(&["watch", "--once", "--connect", &tcp, "--world", "khepera"]);
    assert!(frame.starts_with("world khepera  t = "), "{frame}");
    assert!(frame.contains("##########") && frame.contains('→'), "{frame}");
    assert!(frame.contains("khepera:  ir_0 0.") && frame.contains("encoders.right"), "{frame}");
    assert!(frame.lines().all(|line| line.chars().count() <= 80));
    let (code, _, err) = baudbot(&["watch", "--once", "--connect", &tcp]);
    assert_eq!(code, 1);
    assert!(err.ends_with("choose one with --world: khepera, wander\n"), "{err}");
    let (code, _, err) = baudbot(&["watch", "--once", "--connect", &tcp, "--world", "maze"]);
    assert_eq!(code, 1);
    assert!(err.ends_with("there is no world `maze`; there are: khepera, wander\n"), "{err}");
    let (code, _, err) = baudbot(&["watch", "--once", "--connect", &format!("https://{tcp}")]);
    assert_eq!(code, 1);
    assert!(
        err.contains("the program that listens there does not use TLS; write the address without https://"),
        "{err}"
    );
    let (code, _, err) = baudbot(&["serve", "--listen", &tcp]);
    assert_eq!(code, 1);
    assert!(
        err.starts_with(&format!("error: cannot listen on {tcp}: another program listens there")),
        "{err}"
    );
    server.signal("-INT");
    assert_eq!(server.end().0, 0);
}

#[test]
fn a_huge_world_can_be_watched_and_is_in_nobodys_way() {
    let mut toml = String::new();
    for i in 0..60_000 {
        toml += &format!("[[arena.circles]]\nname = \"{:_<58}{i}\"\n", "pillar");
        toml += &format!("x_m = {}.0\ny_m = {}.0\nradius_m = 0.1\n", i % 250, i / 250);
    }
    let path = place("huge.toml");
    std::fs::write(&path, toml).unwrap();
    let (_server, tcp, _) = serve("huge.sock", &["wander", path.to_str().unwrap()]);
    for world in ["huge", "wander"] {
        let frame = good(&["watch", "--once", "--connect", &tcp, "--world", world]);
        assert!(frame.starts_with(&format!("world {world}  t = ")), "{frame}");
    }
}

#[test]
fn a_second_signal_ends_an_observer_whom_nobody_reads() {
    let (_server, tcp, _) = serve("unread.sock", &["wander"]);
    let mut watch = Running::start(&["watch", "--connect", &tcp]);
    watch.lines_until("world");
    // A pipe holds 64 KiB, a second of frames has more.
    std::thread::sleep(Duration::from_secs(3));
    watch.signal("-INT");
    std::thread::sleep(Duration::from_millis(300));
    watch.signal("-INT");
    assert_eq!(watch.end().0, 130);
}

#[test]
fn a_brain_that_loses_its_server_says_so() {
    let (server, tcp, _) = serve("lost.sock", &["wander"]);
    let named = ["--world", "wander", "--robot", "robot"];
    let brain = ["brain", "constant", "--connect", &tcp, "--reconnect", "off"];
    let mut brain = Running::start(&[&brain, &named[..]].concat());
    assert_eq!(brain.first_complaint(), DRIVING);
    drop(server);
    let (code, _, err) = brain.end();
    assert_eq!(code, 1);
    assert!(err.contains("the connection to the server is lost") && !err.contains("come back"), "{err}");
}

#[test]
fn a_brain_comes_back_to_a_server_that_is_started_again_and_goes_when_its_robot_is_no_more() {
    let (server, _, unix) = serve("back.sock", &["wander"]);
    let mut brain = Running::start(&["brain", "constant", "--connect", &unix]);
    assert_eq!(brain.first_complaint(), DRIVING);
    // One that dies, and one that closes all its connections in good order.
    drop(server);
    let lost = brain.first_complaint();
    assert!(
        lost.contains("the connection to the server is lost")
            && lost.ends_with("trying to reconnect for 600 s\n")
    );
    let (server, ..) = serve("back.sock", &["wander"]);
    let back = "reconnected with a restarted brain: driving robot of world wander\n";
    assert_eq!(brain.first_complaint(), back);
    let (code, _, err) = baudbot(&["brain", "avoid", "--connect", &unix]);
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("robot `robot` of world `wander` is held by brain `constant`"), "{err}");
    server.signal("-TERM");
    assert_eq!(server.end().0, 0);
    assert!(brain.first_complaint().ends_with("trying to reconnect for 600 s\n"));
    // A lasting failure ends it: there is no such robot any more.
    let socket = format!("unix:{}", place("back.sock").display());
    let mut server = Running::start(&["serve", "--listen", &socket, "khepera"]);
    server.lines_until("Ctrl-C");
    let (code, _, err) = brain.end();
    assert_eq!(code, 1);
    assert!(
        err.contains("the brain of robot could not reconnect: ")
            && err.contains("there is no world `wander`"),
        "{err}"
    );
}

#[test]
fn a_brain_that_does_not_find_its_server_again_gives_up_at_its_limit() {
    let (server, _, unix) = serve("gone.sock", &["wander"]);
    let mut brain = Running::start(&["brain", "constant", "--connect", &unix, "--reconnect", "1"]);
    assert_eq!(brain.first_complaint(), DRIVING);
    drop(server);
    let (code, _, err) = brain.end();
    assert_eq!(code, 1);
    assert!(err.contains("the brain of robot could not reconnect: no server answers at unix:"), "{err}");
}

#[test]
fn a_brain_that_is_restarted_begins_anew_and_one_that_is_thrown_off_goes() {
    let (_server, tcp, unix) = serve("restart.sock", &["wander"]);
    let mut brain = Running::start(&["brain", "constant", "--connect", &tcp]);
    assert_eq!(brain.first_complaint(), DRIVING);
    for _ in 0..2 {
        detach_brain(&unix, true).unwrap();
        assert_eq!(brain.first_complaint(), "the operator has restarted the brain of robot\n");
    }
    // The robot stays held by the brain of this name.
    let (code, _, err) = baudbot(&["brain", "avoid", "--connect", &unix]);
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("robot `robot` of world `wander` is held by brain `constant`"), "{err}");
    detach_brain(&unix, false).unwrap();
    let (code, _, err) = brain.end();
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("the operator has detached this brain"), "{err}");
}

/// Throws the brain of the robot of `wander` off.
#[tokio::main(flavor = "current_thread")]
pub(crate) async fn detach_brain(address: &str, restart: bool) -> Result<(), tonic::Status> {
    let server =
        tonic::transport::Endpoint::from_shared(address.to_owned()).unwrap().connect().await.unwrap();
    let detach = v1::DetachBrain { robot: "robot".to_owned(), restart };
    let request = v1::InterveneRequest {
        world: "wander".to_owned(),
        intervention: Some(v1::intervene_request::Intervention::DetachBrain(detach)),
    };
    v1::control_service_client::ControlServiceClient::new(server).intervene(request).await.map(drop)
}

#[test]
fn a_robot_has_one_brain() {
    let (_server, tcp, unix) = serve("held.sock", &["wander", "--paused"]);
    let mut first = Running::start(&["brain", "constant", "--connect", &tcp]);
    assert_eq!(first.first_complaint(), DRIVING);
    let (code, _, err) = baudbot(&["brain", "avoid", "--connect", &unix]);
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("robot `robot` of world `wander` is held by brain `constant`"), "{err}");
    first.signal("-INT");
    assert_eq!(first.end().0, 0);
}

#[test]
fn an_operator_may_delete_the_world_of_a_run() {
    let socket = format!("unix:{}", place("operator.sock").display());
    let csv = place("deleted.csv");
    let _ = std::fs::remove_file(&csv);
    let forever = ["run", "--pace", "real-time", "--seconds", "1000", "--listen", &socket];
    for more in [&["--csv", csv.to_str().unwrap()][..], &["--brain", "none"]] {
        let mut run = Running::start(&[&forever, more].concat());
        assert_eq!(run.first_complaint(), format!("listening on {socket}\n"));
        delete_world(&socket);
        let (code, _, err) = run.end();
        assert_eq!(code, 1);
        assert!(err.contains("world"), "{err}");
    }
    // The world may have been deleted before its first tick: then there is no table.
    let table = std::fs::read_to_string(csv);
    assert!(table.as_ref().is_ok_and(|table| table.starts_with("t_s,")) || table.is_err(), "{table:?}");
}

#[tokio::main(flavor = "current_thread")]
async fn delete_world(address: &str) {
    let server =
        tonic::transport::Endpoint::from_shared(address.to_owned()).unwrap().connect().await.unwrap();
    let request = v1::DeleteWorldRequest { world: "wander".to_owned() };
    v1::control_service_client::ControlServiceClient::new(server).delete_world(request).await.unwrap();
}

#[test]
fn brains_are_listed_with_their_parameters() {
    let list = good(&["brain", "--list"]);
    assert_eq!(list, good(&["brain"]));
    for part in ["avoid: ", "constant: ", "navigate: ", "wander: ", "turn_probability=0.01"] {
        assert!(list.contains(part), "{part}");
    }
}

#[test]
fn every_embedded_scenario_is_explained() {
    for name in ["arsim", "khepera", "wander"] {
        let out = good(&["check", name]);
        assert!(out.starts_with(&format!("{name}: valid\n  name         {name}\n")), "{out}");
        assert!(!out.contains("warning"));
    }
    let wander = good(&["check", "wander"]);
    for part in [
        "6 solid polygons; x from -2 to 2 m, y from -2 to 2 m\n",
        "9600 baud, 10 bits a character: 960 bytes/s\n",
        "19 bytes with all sensors, 19.792 ms on the link\n",
        "uplink    950 bytes/s, 99.0 % of its capacity\n",
    ] {
        assert!(wander.contains(part), "`{part}` is not in:\n{wander}");
    }
    let slow = good(&["check", "wander", "--set", "robots.robot.link.baud=4800"]);
    assert!(slow.contains("197.9 % of its capacity\n  warning: the uplink cannot carry that much"), "{slow}");
}

#[test]
fn a_scenario_is_drawn_into_a_file_or_to_stdout() {
    let path = place("wander.svg");
    let out = good(&["check", "wander", "--svg", path.to_str().unwrap()]);
    assert_eq!(out, good(&["check", "wander"]));
    let picture = std::fs::read_to_string(path).unwrap();
    assert!(picture.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""), "{picture}");
    assert!(picture.ends_with("</svg>\n") && picture.contains("robot.ir_front: ir, range 1 m"), "{picture}");
    assert_eq!(good(&["check", "wander", "--svg", "-"]), picture);
    let moved = good(&["check", "wander", "--svg", "-", "--set", "robots.robot.start.x_m=0.5"]);
    assert_ne!(moved, picture);
}

#[test]
fn help_has_examples() {
    for command in ["run", "sweep", "serve", "brain", "check", "plan", "watch"] {
        assert!(good(&[command, "--help"]).contains(&format!("Examples:\n  baudbot {command}")), "{command}");
    }
    let help = good(&["run", "--help"]);
    let words: Vec<_> = help.split_whitespace().collect();
    assert!(words.join(" ").contains("the exit code is 130"), "{help}");
    assert_eq!(good(&["--version"]), format!("baudbot {}\n", env!("CARGO_PKG_VERSION")));
}

const DRIVING: &str = "driving robot of world wander\n";

/// The default brain cannot drive on the tour, and no brain understands a program with a language of its own.
#[test]
fn a_server_suggests_a_brain_that_can_drive() {
    let greeting = |scenario: &str| {
        let mut server = Running::start(&["serve", scenario, "--listen", "127.0.0.1:0"]);
        let lines = server.lines_until("Ctrl-C");
        server.signal("-INT");
        assert_eq!(server.end().0, 0);
        lines.join("\n")
    };
    let tour = greeting("tour");
    assert!(tour.contains("  baudbot brain tour --connect ") && tour.contains("  baudbot watch "), "{tour}");
    let firmware = greeting("firmware");
    assert!(!firmware.contains("baudbot brain") && firmware.contains("  baudbot watch "), "{firmware}");
}

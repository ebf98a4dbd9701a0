//! Serial ports of `baudbot serve`: what is refused, what stays, and programs that do what they should not.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::os::unix::fs::{OpenOptionsExt as _, PermissionsExt as _, symlink};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use rustix::fs::OFlags;
use tempfile::TempDir;

use crate::cli::{Running, command, good, said};

/// A Khepera that talks at 9600 baud, and a robot far away that rolls by itself.
const KHEPERA: &str = "name = \"ports\"\nstep_ms = 1.0\n\
    [[robots]]\nname = \"k\"\npreset = \"khepera-2\"\nfirmware = { protocol = \"khepera\" }\n\
    link = { baud = 9600, bits_per_character = 11 }\n\
    [[robots]]\nname = \"n\"\nstart = { x_m = 100.0, speed_m_s = 0.3, turn_rate_rad_s = 0.2 }\n\
    body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n\
    sensors.c = { kind = \"compass\", period_ms = 10 }\n";

/// A server in a folder of its own.
struct Served {
    server: Running,
    /// The places of its ports, by its own words.
    places: Vec<String>,
    /// The output of the program by then.
    greeting: String,
    folder: PathBuf,
}

fn prepared(folder: &Path, scenario: &str, args: &[&str]) -> Command {
    fs::write(folder.join("world.toml"), scenario).unwrap();
    let socket = format!("unix:{}", folder.join(format!("{}.sock", args.join("").len())).display());
    let mut all = vec!["serve", "world.toml", "--viewer", "off", "--listen", &socket];
    all.extend(args);
    let mut command = command(&all);
    command.current_dir(folder);
    command
}

/// A server with so many ports.
fn serve(folder: &TempDir, scenario: &str, args: &[&str], ports: usize) -> Served {
    let folder = folder.path().to_owned();
    // The output is not read while the program runs, so it goes to a file.
    let said = File::create(folder.join("stderr")).unwrap();
    started(prepared(&folder, scenario, args).stderr(said), folder, ports)
}

fn started(command: &mut Command, folder: PathBuf, ports: usize) -> Served {
    let mut server = Running(command.spawn().unwrap());
    let (mut places, mut greeting) = (Vec::new(), String::new());
    let mut out = BufReader::new(server.0.stdout.as_mut().unwrap());
    while places.len() < ports {
        let mut line = String::new();
        assert!(
            out.read_line(&mut line).unwrap() > 0,
            "{}",
            fs::read_to_string(folder.join("stderr")).unwrap()
        );
        if let Some((_, place)) =
            line.trim_end().strip_prefix("serial port of ").and_then(|at| at.split_once(": "))
        {
            places.push(place.split(" (").next().unwrap().to_owned());
        }
        greeting += &line;
    }
    Served { server, places, greeting, folder }
}

impl Served {
    /// Stops the program as a user does; returns its lines about ports.
    fn stop(mut self) -> Vec<String> {
        self.server.signal("-INT");
        let mut out = String::new();
        self.server.0.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        assert!(self.server.0.wait().unwrap().success(), "{}", self.complaints());
        out.lines().filter(|line| line.starts_with("port ")).map(str::to_owned).collect()
    }

    fn complaints(&self) -> String {
        fs::read_to_string(self.folder.join("stderr")).unwrap()
    }

    fn open(&self, link: &str) -> File {
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits() as i32;
        OpenOptions::new().read(true).write(true).custom_flags(flags).open(self.folder.join(link)).unwrap()
    }

    /// A connection to the port in this place.
    fn connect(&self, place: usize) -> TcpStream {
        let stream = TcpStream::connect(self.places[place].rsplit_once("tcp:").unwrap().1).unwrap();
        stream.set_nonblocking(true).unwrap();
        stream
    }
}

/// The bytes that come up to the end of a line.
fn line_of(port: &mut impl Read) -> String {
    let (mut line, deadline) = (Vec::new(), Instant::now() + Duration::from_secs(120));
    while !line.ends_with(b"\n") {
        assert!(Instant::now() < deadline, "no answer but {:?}", String::from_utf8_lossy(&line));
        let mut byte = [0];
        match port.read(&mut byte) {
            Ok(0) => panic!("the port is closed after {:?}", String::from_utf8_lossy(&line)),
            Ok(_) => line.push(byte[0]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                std::thread::sleep(Duration::from_millis(2));
            }
            Err(error) => panic!("{error}"),
        }
    }
    String::from_utf8_lossy(&line).trim_end().to_owned()
}

fn asked(port: &mut (impl Read + Write), command: &str) -> String {
    port.write_all(command.as_bytes()).unwrap();
    line_of(port)
}

/// Runs a server that is to end by itself; its exit code and its output.
fn refusal(folder: &TempDir, scenario: &str, args: &[&str]) -> (i32, String) {
    let (code, _, err) = said(prepared(folder.path(), scenario, args).output().unwrap());
    (code, err)
}

/// The real robot's driver at such a port would understand nothing.
#[test]
fn what_no_driver_of_the_real_thing_understands_is_told_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let mut scenario = KHEPERA.to_owned();
    let mut args = vec!["--port".to_owned(), "k=pty:k.tty".to_owned()];
    // A second port of a cable has no second message.
    args.extend(["--port".to_owned(), "r0=unix:r0.sock".to_owned()]);
    scenario += "[[robots]]\nname = \"e\"\npreset = \"e-puck\"\nstart = { y_m = -2 }\n";
    args.extend(["--port".to_owned(), "e=pty:e.tty".to_owned()]);
    for (i, robot) in ["thymio-2", "chalmers-40cm", "turtlebot3-burger"].iter().enumerate() {
        let y = 2 * (i + 1);
        scenario += &format!("[[robots]]\nname = \"r{i}\"\npreset = \"{robot}\"\nstart = {{ y_m = {y} }}\n");
        args.extend(["--port".to_owned(), format!("r{i}=pty:r{i}.tty")]);
    }
    for laser in ["rplidar-a1", "lds-01", "urg-04lx"] {
        scenario += &format!("sensors.{laser} = {{ preset = \"{laser}\" }}\n");
        args.extend(["--port".to_owned(), format!("r2/{laser}=pty:{laser}.tty")]);
    }
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let served = serve(&folder, &scenario, &args, args.len() / 2);
    let greeting = served.greeting.clone();
    let errors = served.folder.join("stderr");
    served.stop();
    let said = fs::read_to_string(errors).unwrap();
    for robot in ["r0", "r1", "r2"] {
        let note = format!(
            "note: {robot} speaks baudbot's own frames; no driver of the real robot understands them, unless"
        );
        assert_eq!(said.matches(&note).count(), 1, "{robot}: {said}");
    }
    for laser in ["rplidar-a1", "lds-01"] {
        let note =
            format!("note: r2/{laser} sends scans by SCIP 2.0 and answers no commands, so no driver of the");
        assert_eq!(said.matches(&note).count(), 1, "{laser}: {said}");
    }
    assert!(
        !said.contains("note: k ") && !said.contains("note: e ") && !said.contains("note: r2/urg-04lx "),
        "{said}"
    );
    // Robots whose programs come through ports are not offered to brains; the other one is.
    assert!(greeting.contains("--robot n\n") && !greeting.contains("--robot k"), "{greeting}");
}

/// The messages are as at a port of the server itself; whether a laser answers, other machines do not know.
#[test]
fn a_port_on_another_machine_tells_what_is_not_understood_too() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = "name = \"ports\"\n[[robots]]\nname = \"r\"\npreset = \"thymio-2\"\n\
        sensors.lds-01 = { preset = \"lds-01\" }\n";
    let server = Running(prepared(folder.path(), scenario, &[]).spawn().unwrap());
    let socket = folder.path().join("0.sock");
    let deadline = Instant::now() + Duration::from_secs(60);
    while !socket.exists() {
        assert!(Instant::now() < deadline, "the server does not listen");
        std::thread::sleep(Duration::from_millis(5));
    }
    let socket = format!("unix:{}", socket.display());
    let mut open = command(&[
        "port",
        "open",
        "r=pty:r.tty",
        "r/lds-01=pty:lds.tty",
        "--connect",
        &socket,
        "--world",
        "ports",
    ]);
    let told = File::create(folder.path().join("stderr")).unwrap();
    let opened = started(open.current_dir(folder.path()).stderr(told), folder.path().to_owned(), 2);
    let said = opened.complaints();
    opened.stop();
    drop(server);
    for note in [
        "note: r speaks baudbot's own frames; no driver of the real robot understands them",
        "note: r/lds-01 speaks SCIP 2.0, which only drivers of lasers by Hokuyo understand",
    ] {
        assert_eq!(said.matches(note).count(), 1, "{note}: {said}");
    }
}

#[test]
fn what_stands_where_a_link_goes_stays() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("k.tty"), "precious").unwrap();
    let (code, err) = refusal(&folder, KHEPERA, &["--port", "k=pty:k.tty"]);
    assert_eq!(code, 2);
    assert!(err.contains("k.tty: a file already exists; remove it, or choose another name"), "{err}");
    assert_eq!(fs::read_to_string(folder.path().join("k.tty")).unwrap(), "precious");
    assert!(!folder.path().join("k.tty.lock").exists());
}

#[test]
fn a_link_that_leads_to_a_terminal_of_others_stays() {
    let folder = tempfile::tempdir().unwrap();
    let master =
        rustix::pty::openpt(rustix::pty::OpenptFlags::RDWR | rustix::pty::OpenptFlags::NOCTTY).unwrap();
    rustix::pty::unlockpt(&master).unwrap();
    let slave = rustix::pty::ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    symlink(&slave, folder.path().join("k.tty")).unwrap();
    let (code, err) = refusal(&folder, KHEPERA, &["--port", "k=pty:k.tty"]);
    assert_eq!(code, 2);
    assert!(err.contains("k.tty: a link to something else already exists"), "{err}");
    assert_eq!(fs::read_link(folder.path().join("k.tty")).unwrap(), Path::new(&slave));
}

#[test]
fn the_link_of_a_killed_server_is_replaced_and_that_of_a_living_one_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["--port", "k=pty:k.tty", "--port", "k=unix:k.sock"];
    let mut first = serve(&folder, KHEPERA, &args, 2);
    for (port, what) in
        [("k=pty:k.tty", "the port of another server"), ("k=unix:k.sock", "a socket that is in use")]
    {
        let (code, err) = refusal(&folder, KHEPERA, &["--port", port]);
        assert_eq!(code, 2);
        assert!(err.contains(what), "{err}");
    }
    assert!(
        !first.complaints().contains("has opened"),
        "a second server is no program: {}",
        first.complaints()
    );
    assert!(asked(&mut first.open("k.tty"), "D,0,0\r").starts_with('d'));
    first.server.0.kill().unwrap();
    first.server.0.wait().unwrap();
    let old = fs::read_link(folder.path().join("k.tty")).unwrap();
    // Other terminals take the number of the killed one; where the kernel gives another number, the link leads nowhere.
    let _others: Vec<_> =
        (0..4).map(|_| rustix::pty::openpt(rustix::pty::OpenptFlags::RDWR).unwrap()).collect();
    let second = serve(&folder, KHEPERA, &args, 2);
    assert_ne!(fs::read_link(folder.path().join("k.tty")).unwrap(), old);
    let metadata = fs::metadata(folder.path().join("k.tty")).unwrap();
    assert_eq!(metadata.permissions().mode() & 0o777, 0o600);
    let socket = fs::metadata(folder.path().join("k.sock")).unwrap();
    assert_eq!(socket.permissions().mode() & 0o777, 0o600);
    assert!(asked(&mut second.open("k.tty"), "D,0,0\r").starts_with('d'));
    second.stop();
    for name in ["k.tty", "k.tty.lock", "k.sock"] {
        assert!(fs::symlink_metadata(folder.path().join(name)).is_err(), "{name} is left");
    }
}

#[test]
fn ports_that_cannot_be_are_refused_with_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let in_use = format!("k=tcp:{}", taken.local_addr().unwrap().port());
    for (args, code, what) in [
        (&["--port", "x=pty:k.tty"][..], 2, "pty:k.tty: there is no robot `x`; there are: k, n"),
        (
            &["--port", "k/c=pty:k.tty"],
            2,
            "robot `k` has no sensor `c` with a port of its own; those with one: none",
        ),
        (&["--port", "pty:k.tty"], 2, "name its robot, as in ROBOT=pty:k.tty; there are: k, n"),
        (&["--port", "k=com:3"], 2, "`com` is not a kind of port; there are pty, tcp, rfc2217 and unix"),
        (&["--port", "k=tcp:0.0.0.0:0"], 2, "other machines could reach this port and drive the robot"),
        (&["--port", &in_use], 1, "cannot be opened: Address already in use"),
        (&["--port", "k=pty:no/such/folder/k.tty"], 1, "cannot be opened: No such file or directory"),
        (&["--port", "k=pty:k.tty", "--pace", "lockstep"], 1, "the world does not follow the wall clock"),
        (&["--port", "k=pty:k.tty", "--pace", "free"], 1, "serial ports need the pace real-time or scaled"),
        (&["--port", "k=pty:k.tty", "wander"], 2, "--port: takes a single world, and there are several"),
    ] {
        let (found, err) = refusal(&folder, KHEPERA, args);
        assert!(err.contains(what), "{args:?}: {err}");
        assert_eq!(found, code, "{args:?}: {err}");
        assert!(!folder.path().join("k.tty").exists());
    }
}

#[test]
fn a_scenario_has_ports_of_its_own_and_others_may_take_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let with = |port: &str| KHEPERA.replace("baud = 9600", &format!("baud = 9600, serial_port = {port}"));
    let scenario = with("[\"pty:k.tty\", \"tcp:0\"]");
    let own = serve(&folder, &scenario, &["--record", "own.mcap"], 2);
    assert_eq!(own.places[0], "k.tty");
    assert!(asked(&mut own.open("k.tty"), "D,0,0\r").starts_with('d'));
    own.stop();
    let other = serve(&folder, &scenario, &["--port", "k=pty:other.tty"], 1);
    assert_eq!(other.places, ["other.tty"]);
    assert!(!folder.path().join("k.tty").exists());
    other.stop();
    let none = refusal(&folder, &scenario, &["--pace", "lockstep"]);
    assert!(none.1.contains("serial ports need the pace real-time or scaled"), "{none:?}");
    let outside = refusal(&folder, &with("\"tcp:0.0.0.0:0\""), &[]);
    assert!(outside.0 == 2 && outside.1.contains("other machines could reach this port"), "{outside:?}");
    let set = ["--set", "robots.k.link.serial_port=[]", "--pace", "lockstep", "--port", "k=com:1"];
    assert_eq!(refusal(&folder, &scenario, &set).0, 2);
    // Nothing else has anything to do with them.
    fs::write(folder.path().join("world.toml"), &scenario).unwrap();
    let world = folder.path().join("world.toml");
    let world = world.to_str().unwrap();
    let checked = good(&["check", world]);
    assert!(checked.contains("k=pty:k.tty, k=tcp:127.0.0.1:0"), "{checked}");
    let run = |text: &str| {
        fs::write(world, text).unwrap();
        good(&["run", world, "--seconds", "0.2", "--brain", "none", "--csv", "-", "--quiet"])
    };
    assert_eq!(run(&scenario), run(KHEPERA));
    good(&["replay", folder.path().join("own.mcap").to_str().unwrap(), "--quiet"]);
    assert!(!folder.path().join("k.tty").exists());
}

#[test]
fn one_program_at_a_time_has_a_cable_whichever_of_its_ports_it_opens() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["--port", "k=pty:k.tty", "--port", "k=tcp:0", "--port", "k=unix:k.sock"];
    let served = serve(&folder, KHEPERA, &args, 3);
    let mut first = served.open("k.tty");
    assert!(asked(&mut first, "D,0,0\r").starts_with('d'));
    assert_eq!(end_of(&mut served.connect(1)), 0, "sent away");
    assert_eq!(end_of(&mut UnixStream::connect(folder.path().join("k.sock")).unwrap()), 0, "sent away");
    assert!(asked(&mut first, "D,0,0\r").starts_with('d'), "the first one keeps the cable");
    drop(first);
    let mut second = connected_at_last(&served, 1);
    // A pty cannot refuse; who opens it is hung up, and its name leads to another one.
    let mut hung_up = served.open("k.tty");
    assert_eq!(end_of(&mut hung_up), 0);
    assert!(hung_up.write_all(b"D,5,5\r").is_err());
    assert!(asked(&mut second, "D,0,0\r").starts_with('d'));
    drop(second);
    let deadline = Instant::now() + Duration::from_secs(120);
    while !answers(&mut served.open("k.tty")) {
        assert!(Instant::now() < deadline, "the pty is not to be had");
    }
    served.stop();
}

/// Waits for the end of a port; how many bytes came before.
fn end_of(port: &mut impl Read) -> usize {
    let (mut bytes, deadline) = (0, Instant::now() + Duration::from_secs(120));
    loop {
        assert!(Instant::now() < deadline, "the port stays open");
        match port.read(&mut [0; 64]) {
            Ok(0) => return bytes,
            Ok(n) => bytes += n,
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                std::thread::sleep(Duration::from_millis(2));
            }
            // A terminal that was hung up, or a connection that was closed before it was used.
            Err(_) => return bytes,
        }
    }
}

/// Whether a Khepera is at the other end. The end of a line ends what others may have begun.
fn answers(port: &mut (impl Read + Write)) -> bool {
    let (mut found, deadline) = (Vec::new(), Instant::now() + Duration::from_secs(60));
    if port.write_all(b"\rD,0,0\r").is_err() {
        return false;
    }
    while !found.ends_with(b"d\r\n") && Instant::now() < deadline {
        let mut bytes = [0; 16];
        match port.read(&mut bytes) {
            Ok(0) => return false,
            Ok(n) => found.extend(&bytes[..n]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                std::thread::sleep(Duration::from_millis(2));
            }
            Err(_) => return false,
        }
    }
    found.ends_with(b"d\r\n")
}

/// A connection at which the robot answers: the cable may not be free at once.
fn connected_at_last(served: &Served, place: usize) -> TcpStream {
    let deadline = Instant::now() + Duration::from_secs(120);
    loop {
        assert!(Instant::now() < deadline, "the cable is not to be had");
        let mut stream = served.connect(place);
        if answers(&mut stream) {
            return stream;
        }
    }
}

#[test]
fn a_thousand_programs_that_come_and_go_leave_the_world_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let served = serve(&folder, KHEPERA, &["--port", "k=pty:k.tty", "--record", "run.mcap"], 1);
    for _ in 0..1000 {
        served.open("k.tty");
    }
    assert!(answers(&mut served.open("k.tty")));
    let complaints = served.complaints();
    assert!(!complaints.contains("cannot"), "{complaints}");
    served.stop();
    neighbour_is_undisturbed(&folder, KHEPERA);
}

#[test]
fn a_program_that_never_reads_and_one_that_writes_half_a_command_harm_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let gps = "[[robots]]\nname = \"g\"\nstart = { x_m = 50.0 }\nlink = { kind = \"ideal\" }\n\
        body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.05 }\n\
        sensors.gps.preset = \"gps-garmin-15\"\n";
    let scenario = format!("{KHEPERA}{gps}");
    let args = ["--port", "k=pty:k.tty", "--port", "g/gps=pty:g.tty", "--record", "run.mcap"];
    let served = serve(&folder, &scenario, &args, 2);
    let (never_reads, mut silent) = (served.open("g.tty"), served.open("k.tty"));
    silent.write_all(b"D,0").unwrap();
    // Two fixes of the receiver are two simulated seconds.
    for _ in 0..2 {
        std::thread::sleep(Duration::from_secs(1));
    }
    assert_eq!(asked(&mut silent, ",0\r"), "d", "the other half of the command");
    drop(never_reads);
    let mut reader = served.open("g.tty");
    line_of(&mut reader);
    assert!(line_of(&mut reader).starts_with("$GP"));
    served.stop();
    neighbour_is_undisturbed(&folder, &scenario);
}

/// The recording has the same bits once more, and the robot without a program goes the way that it goes alone.
fn neighbour_is_undisturbed(folder: &TempDir, scenario: &str) {
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    good(&["replay", &path("run.mcap"), "--quiet"]);
    let recorded = good(&["export", &path("run.mcap"), "--csv", "-", "--quiet"]);
    let rows = |table: &str| {
        let rows = table.lines().filter(|row| row.split(',').any(|cell| cell == "n"));
        rows.map(str::to_owned).collect::<Vec<_>>()
    };
    let recorded = rows(&recorded);
    fs::write(path("alone.toml"), scenario).unwrap();
    let ticks = recorded.len().to_string();
    let alone = rows(&good(&[
        "run",
        &path("alone.toml"),
        "--ticks",
        &ticks,
        "--brain",
        "none",
        "--csv",
        "-",
        "--quiet",
    ]));
    assert!(recorded.len() > 10, "{recorded:?}");
    let differs = recorded.iter().zip(&alone).find(|(a, b)| a != b);
    assert_eq!(differs, None);
}

/// Writes random bytes, and reads whatever comes.
fn flood(stream: &TcpStream, bytes: usize, seed: u32) {
    let mut random = seed;
    let mut stream = stream;
    let (mut written, mut chunk, mut scrap) = (0, [0; 4096], [0; 65536]);
    let deadline = Instant::now() + Duration::from_secs(300);
    while written < bytes {
        assert!(Instant::now() < deadline, "only {written} bytes are taken");
        for byte in &mut chunk {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Ends of lines make commands of them.
            *byte = if random >> 27 == 0 { b'\r' } else { (random >> 19) as u8 };
        }
        let mut rest = &chunk[..];
        while !rest.is_empty() {
            assert!(Instant::now() < deadline, "only {written} bytes are taken");
            match stream.write(rest) {
                Ok(n) => rest = &rest[n..],
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    std::thread::sleep(Duration::from_millis(1));
                }
                Err(error) => panic!("{error}"),
            }
            while stream.read(&mut scrap).is_ok_and(|n| n > 0) {}
        }
        written += chunk.len();
    }
    // Until the server has taken all, and closes the connection.
    stream.shutdown(Shutdown::Write).unwrap();
    end_of(&mut stream);
}

#[test]
fn floods_of_random_bytes_harm_nobody_else_in_any_protocol() {
    let folder = tempfile::tempdir().unwrap();
    let body = "body = { radius_m = 0.1, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.05 }\n";
    let scenario = format!(
        "{}[[robots]]\nname = \"c\"\npreset = \"create-2\"\nlink = {{ kind = \"ideal\" }}\nstart = {{ x_m = 500.0 }}\n\
         [[robots]]\nname = \"l\"\n{body}start = {{ x_m = 900.0 }}\nlink = {{ kind = \"ideal\" }}\n\
         [robots.sensors.laser]\nkind = \"laser\"\nopening_rad = 4.7\nrays = 300\nrange_m = 4.0\nmount = {{ x_m = 0.0 }}\n\
         port = {{ dialogue = \"asked\", link = {{ kind = \"ideal\" }} }}\nclock = {{ period_ms = 100.0 }}\n\
         [robots.sensors.gps]\npreset = \"gps-garmin-15\"\nport = {{ link = {{ kind = \"ideal\" }} }}\n",
        KHEPERA.replace("link = { baud = 9600, bits_per_character = 11 }", "link = { baud = 10_000_000 }")
    );
    let ports = ["k=tcp:0", "c=tcp:0", "l/laser=tcp:0", "l/gps=tcp:0"];
    let mut args: Vec<_> = ports.iter().flat_map(|port| ["--port", port]).collect();
    args.extend(["--record", "run.mcap"]);
    let served = serve(&folder, &scenario, &args, 4);
    // The messages name places by the robots.
    std::thread::scope(|scope| {
        for place in 0..4 {
            let stream = served.connect(place);
            scope.spawn(move || flood(&stream, FLOOD_BYTES, place as u32 + 1));
        }
    });
    let last = connected_at_last(&served, 1);
    drop(last);
    let reports = served.stop();
    let all = format!("{FLOOD_BYTES} from them");
    assert_eq!(reports.iter().filter(|report| report.contains(&all)).count(), 3, "{reports:?}");
    neighbour_is_undisturbed(&folder, &scenario);
}

/// Bytes to each of the ports.
const FLOOD_BYTES: usize = 1 << 20;

#[test]
fn a_world_whose_recording_finds_no_room_goes_on_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let plain = prepared(folder.path(), KHEPERA, &["--port", "k=pty:k.tty", "--record", "run.mcap"]);
    // A file may have 512 blocks; the signal that would end the program is ignored.
    let mut limited = Command::new("sh");
    limited.args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$0\" \"$@\""]);
    limited.arg(plain.get_program()).args(plain.get_args()).current_dir(folder.path());
    limited.stdout(std::process::Stdio::piped()).stderr(File::create(folder.path().join("stderr")).unwrap());
    let served = started(&mut limited, folder.path().to_owned(), 1);
    let deadline = Instant::now() + Duration::from_secs(120);
    while !served.complaints().contains("recording") {
        assert!(Instant::now() < deadline, "{}", served.complaints());
        assert!(answers(&mut served.open("k.tty")));
    }
    assert!(answers(&mut served.open("k.tty")), "the world goes on");
    assert!(served.complaints().contains("File too large"), "{}", served.complaints());
    served.stop();
}

#[test]
fn a_port_that_was_closed_is_free_for_the_next_program_at_once() -> io::Result<()> {
    let folder = tempfile::tempdir()?;
    let served = serve(&folder, KHEPERA, &["--port", "k=tcp:0"], 1);
    for _ in 0..20 {
        assert_eq!(asked(&mut connected_at_last(&served, 0), "D,0,0\r"), "d");
    }
    served.stop();
    Ok(())
}

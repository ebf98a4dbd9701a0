//! `baudbot measure`, at devices that are made of a pair of pseudo-terminals.

use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write};
use std::os::fd::AsFd;
use std::path::Path;
use std::process::Output;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::tcgetattr;

use crate::cli::{Running, baudbot, command, good, place, said};

/// A device on a serial port: it gets bytes and answers with others.
struct Device {
    path: String,
    master: File,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Device {
    fn start(mut answer: impl FnMut(&[u8]) -> Vec<u8> + Send + 'static) -> Self {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let path = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
        let master = File::from(master);
        let is_over = Arc::new(AtomicBool::new(false));
        let (mut end, ends) = (master.try_clone().unwrap(), Arc::clone(&is_over));
        let thread = thread::spawn(move || {
            let mut buffer = [0; 4096];
            while !ends.load(Ordering::Relaxed) {
                match end.read(&mut buffer) {
                    Ok(length) => end.write_all(&answer(&buffer[..length])).unwrap(),
                    // The other end is not open.
                    Err(_) => thread::sleep(Duration::from_millis(2)),
                }
            }
        });
        Self { path, master, is_over, thread: Some(thread) }
    }

    /// One that sends each byte back.
    fn echo() -> Self {
        Self::start(<[u8]>::to_vec)
    }

    /// One that speaks in lines.
    fn lines(mut answer: impl FnMut(&str) -> String + Send + 'static) -> Self {
        let mut line = Vec::new();
        Self::start(move |bytes| {
            let mut answers = Vec::new();
            for byte in bytes {
                if *byte == b'\n' {
                    answers.extend(answer(&String::from_utf8_lossy(&line)).into_bytes());
                    line.clear();
                } else {
                    line.push(*byte);
                }
            }
            answers
        })
    }

    fn settings(&self) -> String {
        format!("{:?}", tcgetattr(self.master.as_fd()).unwrap())
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        // Wakes the thread, which may wait for a byte.
        drop(OpenOptions::new().read(true).write(true).open(&self.path));
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

/// The rows of a table, its notes left out.
fn rows(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect()
}

/// Runs the program with these lines typed.
fn typing(args: &[&str], typed: &str) -> (i32, String, String) {
    let mut child = command(args).stdin(std::process::Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(typed.as_bytes()).unwrap();
    let output: Output = child.wait_with_output().unwrap();
    said(output)
}

#[test]
fn echoes_are_timed_and_the_settings_of_the_port_are_restored() {
    let (device, out) = (Device::echo(), place("echo.csv"));
    let before = device.settings();
    let path = out.to_str().unwrap();
    let words = good(&[
        "measure",
        "echo",
        "--device",
        &device.path,
        "--count",
        "50",
        "--bytes",
        "3",
        "--settle-ms",
        "0",
        "--timeout-ms",
        "60000",
        "--baud",
        "9600",
        "-o",
        path,
    ]);
    assert!(words.contains("echoes  50\n") && words.contains("lost    0\n"), "{words}");
    assert!(words.contains("wire    6.25 ms") || words.contains("wire    6.250 ms"), "{words}");
    let text = fs::read_to_string(&out).unwrap();
    assert!(text.starts_with("# experiment: echo\n"), "{text}");
    assert!(text.contains("\n# baud: 9600\n# bytes: 3\n") && text.ends_with("# lost: 0\n"), "{text}");
    let rows = rows(&out);
    assert_eq!((rows.len(), rows[0].as_str()), (51, "sent_us,received_us"));
    let mut last = -1.0;
    for row in &rows[1..] {
        let (sent, received) = row.split_once(',').unwrap();
        let [sent, received] = [sent, received].map(|number| number.parse::<f64>().unwrap());
        assert!(last < sent && sent < received, "{row}");
        last = sent;
    }
    assert_eq!(device.settings(), before);
}

#[test]
fn an_echo_that_is_lost_is_counted_and_one_that_is_wrong_is_no_echo() {
    let mut number = 0;
    let device = Device::start(move |bytes| {
        number += 1;
        match number {
            4 => Vec::new(),
            7 => vec![0xff; bytes.len()],
            _ => bytes.to_vec(),
        }
    });
    let (code, out, err) = baudbot(&[
        "measure",
        "echo",
        "--device",
        &device.path,
        "--count",
        "10",
        "--settle-ms",
        "0",
        "--timeout-ms",
        "2000",
        "-o",
        "-",
    ]);
    assert_eq!(code, 0, "{err}");
    assert!(out.ends_with("# lost: 2\n"), "{out}");
    assert!(err.contains("echoes  8\n") && err.contains("lost    2\n"), "{err}");
}

#[test]
fn ports_that_are_not_there_not_ports_silent_or_in_use_are_refused_with_a_remedy() {
    let port =
        |device: &str| baudbot(&["measure", "echo", "--device", device, "--settle-ms", "0", "-o", "-"]);
    for (device, words) in [
        ("/dev/ttyUSB77", "--device /dev/ttyUSB77: there is no such device; "),
        ("/dev/null", "--device /dev/null: is not a serial port; "),
        ("/tmp", "--device /tmp: is a directory"),
    ] {
        let (code, _, err) = port(device);
        assert!(code == 2 && err.starts_with(&format!("error: {words}")), "{device}: {err}");
    }
    let (code, _, err) = baudbot(&["measure", "echo"]);
    assert!(code == 2 && err.contains("--device: name the serial port"), "{err}");
    let silent = Device::start(|_| Vec::new());
    let (code, _, err) = baudbot(&[
        "measure",
        "echo",
        "--device",
        &silent.path,
        "--settle-ms",
        "0",
        "--timeout-ms",
        "20",
        "-o",
        "-",
    ]);
    assert!(code == 1 && err.contains("no echo of 5 messages at 115200 baud; is TX wired to RX"), "{err}");
    // The port is open in another program.
    let held = Device::start(|_| Vec::new());
    let other = OpenOptions::new().read(true).write(true).open(&held.path).unwrap();
    rustix::fs::flock(&other, rustix::fs::FlockOperation::LockExclusive).unwrap();
    let (code, _, err) = port(&held.path);
    assert!(code == 2 && err.contains("is in use by another program"), "{err}");
}

#[test]
fn the_sketch_needs_no_device() {
    let sketch = good(&["measure", "echo", "--sketch"]);
    assert!(
        sketch.contains("Serial.begin(115200)") && sketch.contains("Serial.write(Serial.read())"),
        "{sketch}"
    );
}

#[test]
fn a_curve_is_typed_taken_back_and_continued() {
    let out = place("curve.csv");
    let args = ["measure", "curve", "-o", out.to_str().unwrap(), "--readings", "2"];
    let (code, _, err) = typing(&args, "50 mm\n900\n905\n10 cm\n450\n\nundo\n50\n");
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("removed 1 reading at 100 mm") && err.contains("`50` is not a distance"), "{err}");
    let (code, words, err) = typing(&args, "0.2 m\n200\nx\n201\n");
    assert!(code == 0 && err.contains("continuing: 2 rows") && err.contains("`x` is not a number"), "{err}");
    assert!(words.starts_with("4 rows in "), "{words}");
    assert_eq!(rows(&out), ["distance_mm,value_raw", "50,900", "50,905", "200,200", "200,201"]);
    let (code, _, err) = typing(&[&args[..], &["--sensor", "left"]].concat(), "");
    assert!(code == 2 && err.contains("its columns are not distance_mm,value_raw,sensor"), "{err}");
}

#[test]
fn readings_of_a_curve_come_from_the_device() {
    let mut reading = 0;
    let device = Device::lines(move |line| {
        reading += 1;
        if line == "N" { format!("n,1,{},3\r\n", 500 + reading) } else { "?\r\n".to_owned() }
    });
    let out = place("curve-device.csv");
    let path = out.to_str().unwrap();
    let args = [
        "measure",
        "curve",
        "-o",
        path,
        "--device",
        &device.path,
        "--settle-ms",
        "0",
        "--timeout-ms",
        "60000",
        "--ask",
        "N\\n",
        "--number",
        "2",
        "--readings",
        "3",
        "--sensor",
        "ir",
    ];
    let (code, _, err) = typing(&args, "3 cm\n");
    assert!(code == 0 && err.contains("30 mm: 3 readings, mean 502, sd 1"), "{err}");
    assert_eq!(rows(&out), ["distance_mm,value_raw,sensor", "30,501,ir", "30,502,ir", "30,503,ir"]);
    let few = args.map(|arg| if arg == "2" { "7" } else { arg });
    let (code, _, err) = typing(&few, "4 cm\n");
    assert!(code == 0 && err.contains("`n,1,504,3` has no number 7; see --number"), "{err}");
}

/// A robot whose counts grow at the commanded speed, with its commands.
fn robot(told: Arc<std::sync::Mutex<Vec<String>>>) -> Device {
    let (mut speeds, mut counts, mut last) = ([0.0; 2], [0.0; 2], std::time::Instant::now());
    Device::lines(move |line| {
        let passed = last.elapsed().as_secs_f64();
        last = std::time::Instant::now();
        (0..2).for_each(|i| counts[i] += speeds[i] * passed);
        if let Some(command) = line.strip_prefix("D,") {
            told.lock().unwrap().push(line.to_owned());
            let numbers: Vec<f64> = command.split(',').map(|number| number.parse().unwrap()).collect();
            speeds = [numbers[0] * 100.0, numbers[1] * 100.0];
            return "d\r\n".to_owned();
        }
        format!("h,{},{}\r\n", counts[0] as i64, counts[1] as i64)
    })
}

#[test]
fn a_step_is_watched_and_the_robot_is_stopped() {
    let told = Arc::default();
    let (device, out) = (robot(Arc::clone(&told)), place("step.csv"));
    let path = out.to_str().unwrap();
    let args = [
        "measure",
        "step",
        "--device",
        &device.path,
        "--settle-ms",
        "0",
        "--timeout-ms",
        "60000",
        "--command",
        "D,{left},{right}\\n",
        "--ask",
        "H\\n",
        "--left",
        "10",
        "--right",
        "-5",
        "--full",
        "20",
        "--seconds",
        "0.5",
        "--rest-s",
        "0.2",
        "--m-per-count",
        "0.001",
        "--track-m",
        "0.5",
        "-o",
        path,
    ];
    let (code, _, err) = baudbot(&args);
    assert!(code == 2 && err.contains("the robot will move: give it room and add --yes"), "{err}");
    assert!(told.lock().unwrap().is_empty());
    let words = good(&[&args[..], &["--yes"]].concat());
    assert!(words.contains("unanswered  0\n"), "{words}");
    let rows = rows(&out);
    assert_eq!(rows[0], "time_s,command_left,command_right,count_left,count_right,speed_m_s,turn_rate_rad_s");
    assert!(rows[1].ends_with(",0,0,,"), "{rows:?}");
    assert!(
        rows.iter().any(|row| row.split(',').nth(1) == Some("0.5") && row.split(',').nth(2) == Some("-0.25")),
        "{rows:?}"
    );
    assert!(rows.last().unwrap().contains(",0,0,"), "{rows:?}");
    let told = told.lock().unwrap();
    assert_eq!(told[..3], ["D,0,0", "D,10,-5", "D,0,0"], "{told:?}");
    assert_eq!(told.last().unwrap(), "D,0,0");
}

#[test]
fn ctrl_c_stops_the_robot() {
    let told: Arc<std::sync::Mutex<Vec<String>>> = Arc::default();
    let (device, out) = (robot(Arc::clone(&told)), place("step-interrupted.csv"));
    let running = Running::start(&[
        "measure",
        "step",
        "--device",
        &device.path,
        "--settle-ms",
        "0",
        "--timeout-ms",
        "60000",
        "--command",
        "D,{left},{right}\\n",
        "--ask",
        "H\\n",
        "--left",
        "10",
        "--right",
        "10",
        "--seconds",
        "60",
        "--rest-s",
        "0.1",
        "--yes",
        "-o",
        out.to_str().unwrap(),
    ]);
    while told.lock().unwrap().len() < 2 {
        thread::sleep(Duration::from_millis(10));
    }
    running.signal("-INT");
    let (code, _, err) = running.end();
    assert_eq!(code, 130, "{err}");
    assert_eq!(told.lock().unwrap().last().unwrap(), "D,0,0");
}

#[test]
fn a_robot_that_does_not_answer_is_not_told_to_move() {
    let told: Arc<std::sync::Mutex<Vec<String>>> = Arc::default();
    let heard = Arc::clone(&told);
    let device = Device::lines(move |line| {
        heard.lock().unwrap().push(line.to_owned());
        String::new()
    });
    let (code, _, err) = baudbot(&[
        "measure",
        "step",
        "--device",
        &device.path,
        "--settle-ms",
        "0",
        "--timeout-ms",
        "50",
        "--command",
        "D,{left},{right}\\n",
        "--ask",
        "H\\n",
        "--left",
        "10",
        "--right",
        "10",
        "--yes",
        "-o",
        "-",
    ]);
    assert!(code == 1 && err.contains("no answer with the counts of two wheels"), "{err}");
    assert!(told.lock().unwrap().iter().all(|line| line == "H" || line == "D,0,0"));
}

#[test]
fn what_cannot_be_sent_is_refused() {
    let step = ["measure", "step", "--device", "/dev/null", "--left", "1", "--right", "1"];
    for (more, words) in [
        (["--command", "D,{left}", "--ask", "H"], "must have {left} and {right} in it"),
        (["--command", "D,{left},{right}\\q", "--ask", "H"], "`\\q` is not an escape"),
        (["--command", "D,{left},{right}", "--ask", ""], "must have at least one byte"),
    ] {
        let (code, _, err) = baudbot(&[&step[..], &more].concat());
        assert!(code == 2 && err.contains(words), "{err}");
    }
}

//! `baudbot measure echo`: how long bytes take to a device and back.
//!
//! Bytes are sent, and the next are sent when these have come back. The first of each message counts the messages, so
//! that an echo that came too late is not taken for the next.

use std::io::Write;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::Context;

use super::port::{Port, about};
use super::{header, progress, summary};
use crate::args::EchoArgs;
use crate::error::Refused;
use crate::output_files;
use crate::signals::{INTERRUPTED, Stop};
use crate::text::{self, tell};

pub(super) fn echo(args: &EchoArgs) -> anyhow::Result<ExitCode> {
    if args.sketch {
        text::print(SKETCH)?;
        return Ok(ExitCode::SUCCESS);
    }
    let Some(device) = &args.device else {
        return Err(Refused::error("--device: name the serial port, such as --device /dev/ttyUSB0"));
    };
    let mut port = Port::open(&args.port, device)?;
    let unwritable = || format!("cannot write {}", args.output.display());
    let mut file = output_files::open(&args.output).with_context(unwritable)?;
    let mut notes = vec![
        ("experiment", "echo".to_owned()),
        ("device", port.name()),
        ("baud", args.port.baud.to_string()),
        ("bytes", args.bytes.to_string()),
        ("pause_ms", args.pause_ms.to_string()),
    ];
    notes.extend(about(device));
    file.write_all(header(&notes, "sent_us,received_us").as_bytes()).with_context(unwritable)?;
    let outcome = exchange(args, &mut port, &mut file)?;
    writeln!(file, "# lost: {}", outcome.lost).and_then(|()| file.flush()).with_context(unwritable)?;
    let words = outcome.words(args);
    if args.output.as_os_str() == "-" {
        tell!("{}", words.trim_end());
    } else {
        text::print(&words)?;
    }
    Ok(if outcome.is_stopped { ExitCode::from(INTERRUPTED) } else { ExitCode::SUCCESS })
}

/// The result of the echoes.
struct Outcome {
    /// The times of the echoes, in milliseconds.
    times_ms: Vec<f64>,
    lost: u32,
    is_stopped: bool,
}

/// Sends and receives until there have been enough, or Ctrl-C.
fn exchange(args: &EchoArgs, port: &mut Port, file: &mut dyn Write) -> anyhow::Result<Outcome> {
    let stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    let bar = progress(args.count, "echoes", args.quiet);
    let start = Instant::now();
    let mut outcome = Outcome { times_ms: Vec::new(), lost: 0, is_stopped: false };
    for i in 0..args.count {
        if stop.is_wanted() {
            outcome.is_stopped = true;
            break;
        }
        match once(args, port, i)? {
            Some([sent, received]) => {
                let [sent_us, received_us] = [sent, received].map(|at| (at - start).as_secs_f64() * 1e6);
                writeln!(file, "{sent_us:.3},{received_us:.3}").context("cannot write the table")?;
                outcome.times_ms.push((received_us - sent_us) * 1e-3);
            }
            None => outcome.lost += 1,
        }
        if outcome.times_ms.is_empty() && outcome.lost >= GIVES_UP_AFTER.min(args.count) {
            return Err(silent(args, port));
        }
        bar.inc(1);
        std::thread::sleep(Duration::from_millis(args.pause_ms.into()));
    }
    bar.finish_and_clear();
    Ok(outcome)
}

/// One message and its echo: when it was sent, and when its last byte was back. `None` if that did not come in time, or
/// something else came.
fn once(args: &EchoArgs, port: &mut Port, i: u32) -> anyhow::Result<Option<[Instant; 2]>> {
    let message: Vec<u8> = (0..args.bytes).map(|place| (i.wrapping_add(place) % 256) as u8).collect();
    let mut echo = vec![0; message.len()];
    let sent = Instant::now();
    port.write(&message)?;
    let deadline = sent + Duration::from_millis(args.port.timeout_ms.into());
    let mut length = 0;
    while length < echo.len() {
        let read = port.read(&mut echo[length..], deadline)?;
        if read == 0 {
            break;
        }
        length += read;
    }
    let received = Instant::now();
    if length == echo.len() && echo == message {
        return Ok(Some([sent, received]));
    }
    // Whatever is still on its way would be taken for the next echo.
    let quiet = Duration::from_millis(args.port.timeout_ms.min(LONGEST_QUIET_MS).into());
    while port.read(&mut [0; 256], Instant::now() + quiet)? > 0 {}
    Ok(None)
}

fn silent(args: &EchoArgs, port: &Port) -> anyhow::Error {
    anyhow::anyhow!(
        "{}: no echo of {GIVES_UP_AFTER} messages at {} baud; is TX wired to RX, or the echo sketch on the board (`baudbot measure \
         echo --sketch`)? Does it use this baud rate? Does it need longer to start (--settle-ms)?",
        port.name(),
        args.port.baud
    )
}

impl Outcome {
    fn words(&self, args: &EchoArgs) -> String {
        let wire_ms = 2.0 * 10.0 * f64::from(args.bytes) / f64::from(args.port.baud) * 1e3;
        let mut words = summary("echoes", &self.times_ms, "ms");
        words += &format!("lost    {}\n", self.lost);
        words += &format!("wire    {wire_ms:.3} ms of that, there and back with 10 bits a byte\n");
        words
    }
}

/// The number of lost messages at the start after which the device is taken not to answer.
const GIVES_UP_AFTER: u32 = 5;
/// The time for which it must be quiet after a lost message, or the time-out if that is less.
const LONGEST_QUIET_MS: u32 = 200;

/// The sketch that makes a board send all bytes back.
const SKETCH: &str = "\
// Echo for `baudbot measure echo`: each byte goes back at once.
void setup() {
  Serial.begin(115200);  // the same as --baud
}

void loop() {
  while (Serial.available() > 0) {
    Serial.write(Serial.read());
  }
}
";

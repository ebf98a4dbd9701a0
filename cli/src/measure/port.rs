//! A serial port: raw bytes at a baud rate, with deadlines. Whatever ends the measurement, the port's settings are restored.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{FlockOperation, OFlags, flock};
use rustix::io::Errno;
use rustix::termios::{
    ControlModes, OptionalActions, QueueSelector, Termios, ioctl_tiocexcl, ioctl_tiocnxcl, tcdrain, tcflush,
    tcgetattr, tcsetattr,
};

use crate::args::PortArgs;
use crate::error::Refused;

/// An open serial port, ours alone.
pub(super) struct Port {
    file: File,
    path: PathBuf,
    /// The port's settings when it was opened.
    before: Termios,
}

impl Port {
    /// Opens it, and waits until a board that restarts when its port is opened is ready.
    pub(super) fn open(args: &PortArgs, device: &Path) -> anyhow::Result<Self> {
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits().cast_signed();
        let opened = OpenOptions::new().read(true).write(true).custom_flags(flags).open(device);
        let file = opened.map_err(|error| unopened(device, &error))?;
        let before = tcgetattr(&file).map_err(|error| match error {
            Errno::NOTTY | Errno::INVAL => refused(device, format!("is not a serial port; {}", connected())),
            error => unopened(device, &error.into()),
        })?;
        flock(&file, FlockOperation::NonBlockingLockExclusive).map_err(|_| busy(device))?;
        let port = Self { file, path: device.to_owned(), before };
        port.configure(args.baud)?;
        // Programs that open the port from now on get the error that it is busy.
        ioctl_tiocexcl(&port.file).with_context(|| port.trouble("cannot be locked"))?;
        thread::sleep(Duration::from_millis(args.settle_ms.into()));
        port.discard()?;
        Ok(port)
    }

    /// Eight bits without parity, and every byte as it is.
    fn configure(&self, baud: u32) -> anyhow::Result<()> {
        let mut settings = self.before.clone();
        settings.make_raw();
        settings.control_modes |= ControlModes::CREAD | ControlModes::CLOCAL;
        settings.control_modes -= ControlModes::CSTOPB | ControlModes::CRTSCTS;
        let set =
            settings.set_speed(baud).and_then(|()| tcsetattr(&self.file, OptionalActions::Now, &settings));
        let now = set.and_then(|()| tcgetattr(&self.file));
        if now.is_ok_and(|now| now.output_speed() == baud) {
            return Ok(());
        }
        Err(refused(&self.path, format!("does not support {baud} baud; choose another --baud")))
    }

    /// Throws away what has come and was not read.
    pub(super) fn discard(&self) -> anyhow::Result<()> {
        tcflush(&self.file, QueueSelector::IFlush).with_context(|| self.trouble("cannot be read"))
    }

    /// Writes all of these bytes.
    pub(super) fn write(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        let mut left = bytes;
        let deadline = Instant::now() + WRITE_TIMEOUT;
        while !left.is_empty() {
            match self.file.write(left) {
                Ok(written) => left = &left[written..],
                Err(error) if is_for_later(&error) => {
                    if !self.wait(PollFlags::OUT, deadline)? {
                        anyhow::bail!(self.trouble("accepts no bytes; is it connected?"));
                    }
                }
                Err(error) => return Err(self.lost(error)),
            }
        }
        Ok(())
    }

    /// Waits until all that was written is on the wire.
    pub(super) fn drain(&self) {
        let _ = tcdrain(&self.file);
    }

    /// Reads what has come by the deadline: at least a byte, or none if nothing has.
    pub(super) fn read(&mut self, buffer: &mut [u8], deadline: Instant) -> anyhow::Result<usize> {
        loop {
            match self.file.read(buffer) {
                Ok(0) => return Err(self.lost(ErrorKind::UnexpectedEof.into())),
                Ok(read) => return Ok(read),
                Err(error) if is_for_later(&error) => {
                    if !self.wait(PollFlags::IN, deadline)? {
                        return Ok(0);
                    }
                }
                Err(error) => return Err(self.lost(error)),
            }
        }
    }

    /// Reads a line, without its end, by the deadline; `None` if none has come. What has come of one is thrown away then.
    pub(super) fn line(&mut self, deadline: Instant) -> anyhow::Result<Option<String>> {
        let mut line = Vec::new();
        loop {
            let mut byte = [0];
            if self.read(&mut byte, deadline)? == 0 {
                return Ok(None);
            }
            match byte[0] {
                b'\n' | b'\r' if line.is_empty() => {}
                b'\n' | b'\r' => return Ok(Some(String::from_utf8_lossy(&line).into_owned())),
                byte if line.len() < LONGEST_LINE => line.push(byte),
                _ => line.clear(),
            }
        }
    }

    /// Waits until the port can be read or written; false if the deadline has come first.
    fn wait(&self, what: PollFlags, deadline: Instant) -> anyhow::Result<bool> {
        let left = deadline.saturating_duration_since(Instant::now());
        let timeout = Timespec::try_from(left).context("a time-out is too long")?;
        match poll(&mut [PollFd::new(&self.file, what)], Some(&timeout)) {
            Ok(0) => Ok(false),
            Ok(_) | Err(Errno::INTR) => Ok(true),
            Err(error) => Err(self.lost(error.into())),
        }
    }

    /// The port's name, for messages.
    pub(super) fn name(&self) -> String {
        self.path.display().to_string()
    }

    fn trouble(&self, what: &str) -> String {
        format!("{} {what}", self.path.display())
    }

    fn lost(&self, error: io::Error) -> anyhow::Error {
        anyhow::Error::from(error).context(self.trouble("has gone; was it unplugged?"))
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        let _ = ioctl_tiocnxcl(&self.file);
        let _ = tcsetattr(&self.file, OptionalActions::Now, &self.before);
    }
}

/// The properties of a port that matter to its timing, by the system: names and values.
pub(super) fn about(device: &Path) -> Vec<(&'static str, String)> {
    let real = fs::canonicalize(device).unwrap_or_else(|_| device.to_owned());
    let Some(name) = real.file_name() else { return Vec::new() };
    let system = Path::new("/sys/class/tty").join(name).join("device");
    let driver = fs::read_link(system.join("driver")).ok();
    let driver = driver.and_then(|driver| Some(driver.file_name()?.to_str()?.to_owned()));
    // The latency timer exists for FTDI's adapters only.
    let timer = fs::read_to_string(system.join("latency_timer")).ok().map(|timer| timer.trim().to_owned());
    [("driver", driver), ("latency_timer_ms", timer)]
        .into_iter()
        .filter_map(|(name, value)| Some((name, value?)))
        .collect()
}

fn is_for_later(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

fn refused(device: &Path, problem: impl std::fmt::Display) -> anyhow::Error {
    Refused::error(format!("--device {}: {problem}", device.display()))
}

fn busy(device: &Path) -> anyhow::Error {
    let problem = "is in use by another program; close that, such as a serial monitor (`fuser -v` with the device names it)";
    refused(device, problem)
}

fn unopened(device: &Path, error: &io::Error) -> anyhow::Error {
    let kind = error.kind();
    if kind == ErrorKind::PermissionDenied {
        let remedy = "join the group that owns it, usually dialout (`sudo usermod -aG dialout $USER`), and log in again";
        return refused(device, format!("permission denied; {remedy}"));
    }
    if kind == ErrorKind::NotFound {
        return refused(device, format!("there is no such device; {}", connected()));
    }
    if kind == ErrorKind::IsADirectory {
        return refused(device, format!("is a directory; {}", connected()));
    }
    if kind == ErrorKind::ResourceBusy { busy(device) } else { refused(device, error) }
}

/// The serial ports that there are, for messages.
fn connected() -> String {
    let names = fs::read_dir("/dev").into_iter().flatten().flatten();
    let names = names.filter_map(|entry| entry.file_name().into_string().ok());
    let is_port = |name: &String| PORTS.iter().any(|start| name.starts_with(start));
    let mut ports: Vec<_> = names.filter(is_port).map(|name| format!("/dev/{name}")).collect();
    ports.sort();
    match ports.as_slice() {
        [] => "no USB serial port is connected".to_owned(),
        ports => format!("connected are: {}", ports.join(", ")),
    }
}

/// The beginnings of the names of serial ports of USB, on Linux and macOS.
const PORTS: [&str; 3] = ["ttyUSB", "ttyACM", "cu.usb"];
/// A port that takes nothing for so long is stuck.
const WRITE_TIMEOUT: Duration = Duration::from_secs(2);
/// Bytes of the longest line that is read.
const LONGEST_LINE: usize = 4096;

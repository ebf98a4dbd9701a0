//! Pseudo-terminals: a program opens the slave as a serial port; the master is the other end of the cable.
//!
//! A pty has no UART, so this side does what one would: it reads how the program has set its end (`tcgetattr` on the
//! master gives the slave's settings). The slave is kept open only by programs, so that opening and closing are seen as
//! the end and the return of a hang-up. Linux's ptys have 8 data bits and no parity, whatever a program asks for.

use std::fs;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use baudbot_fields::endpoint::Endpoint;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_setfl};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{
    ControlModes, InputModes, OptionalActions, QueueSelector, Termios, tcflush, tcgetattr, tcsetattr,
};

use crate::claim::Claim;
use crate::error::PortError;
use crate::watch::Watch;
use baudbot_board::far_end::{LineError, Parity, Read, Settings};

/// The slave does not become the terminal that controls this program.
const NOCTTY: i32 = OFlags::NOCTTY.bits() as i32;

/// A pseudo-terminal under a stable name.
#[derive(Debug)]
pub(crate) struct Pty {
    master: OwnedFd,
    slave: PathBuf,
    /// The watch for programs that open the slave; none if the system has no watch left (fs.inotify.max_user_instances).
    watch: Option<Watch>,
    /// The settings of the slave before a program changes them.
    settings: Option<Settings>,
    claim: Claim,
}

impl Pty {
    /// A pty whose slave is `link`, raw, and set as the robot is.
    pub(crate) fn open(link: &Path, settings: Option<&Settings>) -> Result<Self, PortError> {
        let failed =
            |source: io::Error| PortError::Open { place: Endpoint::Pty(link.display().to_string()), source };
        let mut claim = Claim::new(link)?;
        let (master, slave) = new(settings).map_err(failed)?;
        let watch = Watch::new(&slave).ok();
        claim.point_to(&slave).map_err(failed)?;
        Ok(Self { master, slave, watch, settings: settings.copied(), claim })
    }

    /// Hangs up the program that has the slave open: the name leads to another one from now on.
    pub(crate) fn hang_up(&mut self) -> io::Result<()> {
        let (master, slave) = new(self.settings.as_ref())?;
        let watch = Watch::new(&slave).ok();
        self.claim.point_to(&slave)?;
        (self.master, self.slave, self.watch) = (master, slave, watch);
        Ok(())
    }

    /// The pty's stable name.
    pub(crate) fn link(&self) -> &Path {
        self.claim.link()
    }

    pub(crate) fn fd(&self) -> BorrowedFd<'_> {
        self.master.as_fd()
    }

    /// The device that its name stands for.
    pub(crate) fn slave(&self) -> &Path {
        &self.slave
    }

    /// Whether a program has the pty open.
    pub(crate) fn is_open(&self) -> bool {
        let mut fds = [PollFd::new(&self.master, PollFlags::OUT)];
        let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
        poll(&mut fds, Some(&at_once)).is_ok() && !fds[0].revents().contains(PollFlags::HUP)
    }

    /// The descriptor to wait at until a program opens it, if the system has one.
    pub(crate) fn watch_fd(&self) -> Option<BorrowedFd<'_>> {
        self.watch.as_ref().map(Watch::fd)
    }

    /// Whether a program has opened it since the last look.
    pub(crate) fn was_opened(&self) -> bool {
        self.watch.as_ref().is_some_and(|watch| watch.look().opened > 0)
    }

    /// A program has closed it: what it has not read is not for the next one. Linux would keep that. Returns whether
    /// another program has opened it meanwhile.
    pub(crate) fn forget_unread(&self) -> bool {
        let was_opened = self.was_opened();
        let Ok(slave) = fs::OpenOptions::new().read(true).custom_flags(NOCTTY).open(&self.slave) else {
            return was_opened;
        };
        let _ = tcflush(&slave, QueueSelector::IFlush);
        drop(slave);
        // One of them is this program, which cannot write to it.
        let seen = self.watch.as_ref().map(Watch::look).unwrap_or_default();
        was_opened || seen.opened > 1 || seen.writer_gone
    }

    /// The program's settings of its end.
    pub(crate) fn settings(&self) -> Option<Settings> {
        let termios = tcgetattr(&self.master).ok()?;
        Some(settings(&termios)).filter(|settings| settings.baud > 0)
    }

    /// The bytes that a terminal gives the program for one that its UART has read.
    pub(crate) fn as_read(&self, read: &Read) -> Vec<u8> {
        let Ok(termios) = tcgetattr(&self.master) else { return vec![read.byte] };
        given(termios.input_modes, read)
    }

    pub(crate) fn read(&self, buffer: &mut [u8]) -> io::Result<usize> {
        Ok(rustix::io::read(&self.master, buffer)?)
    }

    pub(crate) fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        Ok(rustix::io::write(&self.master, bytes)?)
    }
}

/// A terminal, raw and set so: its master, and the name of its slave, which is not open yet.
fn new(settings: Option<&Settings>) -> io::Result<(OwnedFd, PathBuf)> {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
    grantpt(&master)?;
    unlockpt(&master)?;
    let slave = PathBuf::from(ptsname(&master, Vec::new())?.into_string().map_err(io::Error::other)?);
    fs::set_permissions(&slave, fs::Permissions::from_mode(0o600))?;
    // Whether a program has the slave open is known only once it has been open.
    let opened = fs::OpenOptions::new().read(true).write(true).custom_flags(NOCTTY).open(&slave)?;
    let mut termios = tcgetattr(&opened)?;
    termios.make_raw();
    if let Some(settings) = settings {
        set(&mut termios, settings)?;
    }
    tcsetattr(&opened, OptionalActions::Now, &termios)?;
    fcntl_setfl(&master, OFlags::RDWR | OFlags::NONBLOCK)?;
    Ok((master, slave))
}

/// Errors as a terminal passes them on (termios(3): IGNPAR, INPCK, IGNBRK). Marks of PARMRK cannot be made from this
/// side, as the terminal would mark them again: bytes are given as without it.
fn given(modes: InputModes, read: &Read) -> Vec<u8> {
    let is_break = read.error == Some(LineError::Framing) && read.byte == 0;
    match read.error {
        None => vec![read.byte],
        Some(_) if is_break && modes.contains(InputModes::IGNBRK) => vec![],
        Some(_) if is_break => vec![0],
        Some(_) if !modes.contains(InputModes::INPCK) => vec![read.byte],
        Some(_) if modes.contains(InputModes::IGNPAR) => vec![],
        Some(_) => vec![0],
    }
}

fn settings(termios: &Termios) -> Settings {
    let modes = termios.control_modes;
    let data_bits = match modes & ControlModes::CSIZE {
        size if size == ControlModes::CS5 => 5,
        size if size == ControlModes::CS6 => 6,
        size if size == ControlModes::CS7 => 7,
        _ => 8,
    };
    let is = |mode| modes.contains(mode);
    let parity = match (is(ControlModes::PARENB), is(ControlModes::CMSPAR), is(ControlModes::PARODD)) {
        (false, _, _) => Parity::None,
        (true, false, false) => Parity::Even,
        (true, false, true) => Parity::Odd,
        (true, true, false) => Parity::Space,
        (true, true, true) => Parity::Mark,
    };
    let stop_bits = if is(ControlModes::CSTOPB) { 2 } else { 1 };
    Settings { baud: termios.output_speed(), data_bits, parity, stop_bits }
}

fn set(termios: &mut Termios, settings: &Settings) -> io::Result<()> {
    termios.set_speed(settings.baud)?;
    let modes = &mut termios.control_modes;
    modes.remove(ControlModes::CSIZE);
    modes.insert(match settings.data_bits {
        5 => ControlModes::CS5,
        6 => ControlModes::CS6,
        7 => ControlModes::CS7,
        _ => ControlModes::CS8,
    });
    modes.set(ControlModes::CSTOPB, settings.stop_bits > 1);
    modes.set(ControlModes::PARENB, settings.parity != Parity::None);
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};
    use std::os::unix::fs::symlink;

    use super::*;

    fn read(byte: u8, error: Option<LineError>) -> Read {
        Read { byte, at_ns: 0, error }
    }

    #[test]
    fn a_program_s_settings_are_read_at_the_other_end() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("robot.tty");
        let wanted = Settings { baud: 9600, data_bits: 8, parity: Parity::None, stop_bits: 2 };
        let pty = Pty::open(&link, Some(&wanted)).unwrap();
        assert_eq!(pty.settings(), Some(wanted));
        assert!(!pty.is_open());
        let program = fs::OpenOptions::new().read(true).write(true).open(&link).unwrap();
        assert!(pty.is_open());
        let mut termios = tcgetattr(&program).unwrap();
        let odd = Settings { baud: 250_000, data_bits: 8, parity: Parity::None, stop_bits: 1 };
        set(&mut termios, &odd).unwrap();
        tcsetattr(&program, OptionalActions::Now, &termios).unwrap();
        assert_eq!(pty.settings(), Some(odd));
        drop(program);
        assert!(!pty.is_open());
        let mode = fs::metadata(pty.slave()).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        drop(pty);
        assert!(fs::symlink_metadata(&link).is_err(), "the name is gone with the port");
    }

    #[test]
    fn what_stands_in_the_way_stays_and_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("robot.tty");
        fs::write(&link, "precious").unwrap();
        let error = Pty::open(&link, None).unwrap_err().to_string();
        assert!(
            error.ends_with("robot.tty: a file already exists; remove it, or choose another name"),
            "{error}"
        );
        assert_eq!(fs::read_to_string(&link).unwrap(), "precious");
        fs::remove_file(&link).unwrap();
        symlink("/nowhere/at/all", &link).unwrap();
        let first = Pty::open(&link, None).unwrap();
        assert!(Pty::open(&link, None).is_err(), "a second server");
        drop(first);
        assert!(Pty::open(&folder.path().join("no/such/robot.tty"), None).is_err());
    }

    #[test]
    fn who_opens_it_is_noticed_however_soon_it_is_closed() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("robot.tty");
        let pty = Pty::open(&link, None).unwrap();
        assert!(!pty.was_opened(), "this program does not count");
        drop(fs::OpenOptions::new().read(true).write(true).open(&link).unwrap());
        assert!(pty.was_opened() && !pty.was_opened());
        assert!(!pty.forget_unread(), "this program does not count");
        assert!(!pty.was_opened());
    }

    #[test]
    fn who_has_it_open_is_hung_up_and_the_name_leads_to_another_terminal() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("robot.tty");
        let mut pty = Pty::open(&link, None).unwrap();
        let mut program = fs::OpenOptions::new().read(true).write(true).open(&link).unwrap();
        let first = pty.slave().to_owned();
        pty.hang_up().unwrap();
        assert!(!pty.is_open());
        assert_ne!(pty.slave(), first);
        assert_eq!(fs::read_link(&link).unwrap(), pty.slave());
        assert_eq!(program.read(&mut [0]).unwrap_or(0), 0, "the end of the terminal");
        assert!(program.write(b"N").is_err());
    }

    #[test]
    fn errors_are_given_as_termios_says() {
        let (none, check) = (InputModes::empty(), InputModes::INPCK);
        assert_eq!(given(none, &read(7, Some(LineError::Parity))), [7]);
        assert_eq!(given(check, &read(7, Some(LineError::Parity))), [0]);
        assert!(given(check | InputModes::IGNPAR, &read(7, Some(LineError::Framing))).is_empty());
        assert_eq!(given(InputModes::PARMRK, &read(0xff, None)), [0xff], "the terminal doubles it itself");
        assert_eq!(given(none, &read(0, Some(LineError::Framing))), [0], "a break");
        assert!(given(InputModes::IGNBRK, &read(0, Some(LineError::Framing))).is_empty());
    }
}

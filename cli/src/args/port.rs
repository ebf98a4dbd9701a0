//! `baudbot port`, and the ports of `baudbot serve`.

use baudbot_port::PortAddress;
use clap::{Args, Subcommand};

use super::ConnectArgs;
use super::port_watch::WatchPortArgs;

pub(super) const PORT_HELP: &str = "\
Open a serial port on the cable of a robot, or of one of its sensors, for programs not written for baudbot

  khepera=pty:khepera.tty        a pseudo-terminal; khepera.tty is a symbolic link to it, mode 0600
  create=rfc2217:2217            a terminal server at 127.0.0.1:2217: rfc2217://localhost:2217 in pyserial
  create=tcp:2218                a TCP socket with the bytes alone
  khepera/urg=tcp:10940          the bytes of the sensor `urg`, which has a cable of its own
  create=unix:create.sock        a Unix socket, mode 0600

The robot's name can be left out if there is only one robot. If a cable has several ports, one program at a time can use it. Ports given
to `serve` replace those of the scenario on the same cable (link.serial_port). A program that opens a port takes the place of the brain
(docs/reference/ports.md).";

#[derive(Debug, Subcommand)]
pub(crate) enum PortCommand {
    /// Opens serial ports on the cables of a server's robots, until Ctrl-C
    #[command(after_long_help = EXAMPLES)]
    Open(OpenPortArgs),
    /// Prints and decodes the bytes on a cable as they arrive, until Ctrl-C
    Watch(WatchPortArgs),
}

#[derive(Debug, Args)]
pub(crate) struct OpenPortArgs {
    #[command(flatten)]
    pub(crate) server: ConnectArgs,
    /// The ports to open
    #[arg(value_name = "ROBOT[/SENSOR]=KIND:WHERE", required = true, long_help = PORT_HELP)]
    pub(crate) ports: Vec<PortAddress>,
    /// Allow programs of other users, and addresses that other machines can reach; any program that connects can drive the robot
    #[arg(long)]
    pub(crate) open: bool,
}

const EXAMPLES: &str = "\
Examples:
  baudbot port open khepera=pty:khepera.tty --connect robots.lab:7400
  baudbot port open pty:/tmp/robot.tty            for the only robot of the only world at 127.0.0.1:7400";

//! The arguments of `baudbot program`.

use baudbot_run::programs::PROGRAM;
use clap::Args;

use super::RunArgs;

/// A program that opens serial ports.
#[derive(Debug, Args)]
pub(crate) struct ProgramArgs {
    /// Robot whose cables the ports are [default: all robots, each with a process of its own]
    #[arg(long, value_name = "NAME")]
    robot: Option<String>,
    /// Path at which the program opens a cable: `robot` is that of the robot, others have the names of its sensors [default:
    /// /dev/ttyUSB0=robot, and /dev/ttyUSB1 and so on for sensors with cables of their own]
    #[arg(long = "port", value_name = "/dev/NAME=CABLE", value_parser = port)]
    ports: Vec<String>,
    /// Simulated time that each call costs that does not wait, such as 5us [default: computing takes no time]
    ///
    /// The price is the same in each run. Without one, only calls that are made over and over without waiting take time, so that a program
    /// that polls does not stop the clock.
    #[arg(long, value_name = "TIME")]
    cpu_price: Option<String>,
    #[command(flatten)]
    run: RunArgs,
    /// The program and its arguments; {baud}, {seed} and {robot} stand for those of the run
    #[arg(last = true, required = true, value_name = "PROGRAM")]
    words: Vec<String>,
}

fn port(text: &str) -> Result<String, &'static str> {
    let is_one =
        text.split_once('=').is_some_and(|(path, cable)| path.starts_with("/dev/") && !cable.is_empty());
    if is_one {
        Ok(text.to_owned())
    } else {
        Err("write a path below /dev and a cable, as in /dev/ttyUSB0=robot")
    }
}

impl ProgramArgs {
    /// The run with this program as a brain. Words that cannot be written in a line have a zero byte, which no argument has.
    pub(crate) fn into_run(self) -> RunArgs {
        let Self { robot, ports, cpu_price, mut run, words } = self;
        let settings = ports.into_iter().chain(cpu_price.map(|price| format!("price={price}")));
        let words: Vec<_> = settings.chain(words).collect();
        let line = shlex::try_join(words.iter().map(String::as_str)).unwrap_or_default();
        let robot = robot.map_or_else(String::new, |robot| format!("{robot}="));
        run.brains.push(format!("{robot}{PROGRAM}{line}"));
        run
    }
}

/// Examples for the help.
pub(crate) const EXAMPLES: &str = "\
Examples:
  baudbot program khepera -- python3 driver.py          the driver opens /dev/ttyUSB0
  baudbot program create.toml --port /dev/ttyACM0=robot --seconds 60 -- ./drive --baud {baud}
  baudbot run create.toml --brain 'program:/dev/ttyACM0=robot ./drive'
                                                        the same as a brain, also in experiments and exercises
";

//! `baudbot budget`.

use std::path::PathBuf;

use baudbot_fields::Writes;
use clap::Args;

use super::{ChangeArgs, measure};

#[derive(Debug, Args)]
pub(crate) struct BudgetArgs {
    /// A scenario file, or a built-in scenario, such as wander or devices/laser (`baudbot list`)
    pub(crate) scenario: String,
    /// Only this robot; may be given several times [default: all]
    #[arg(long = "robot", value_name = "ROBOT")]
    pub(crate) robots: Vec<String>,
    /// The brain assumed for one robot, or for all robots that no other --brain names, as in `baudbot run`
    ///
    /// A budget depends on when the brain writes commands, which built-in brains declare. A program (`exec:…`) is assumed to answer
    /// each message once and to write nothing else. The default is `avoid` for robots with IR sensors; for other robots, a brain that
    /// answers each message once.
    #[arg(long = "brain", value_name = "[ROBOT=]BRAIN[:K=V,…]")]
    pub(crate) brains: Vec<String>,
    /// Override when brains write commands: on-message, when-free, every-tick, or a number per second such as 10-per-s
    #[arg(long, value_name = "WHEN")]
    pub(crate) writes: Option<Writes>,
    /// Write JSON, with units in the names
    #[arg(long)]
    pub(crate) json: bool,
    /// Draw the typical cycle of a robot as a timing diagram in SVG; `-` is stdout
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    pub(crate) svg: Option<PathBuf>,
    /// Use the thinking times measured in a recorded run instead of the scenario's
    ///
    /// A run in real time records them; a run in lockstep records those of brains that are programs (`baudbot run --brain 'exec:…'
    /// --record FILE`). The longest recorded time is the worst case.
    #[arg(long, value_name = "RUN.mcap")]
    pub(crate) measured: Option<PathBuf>,
    /// Length of the run that measures a program on a robot's chip, in simulated seconds; other robots need no run
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = measure::seconds)]
    pub(crate) seconds: f64,
    /// Exit with code 1 if a robot misses its deadline
    #[arg(long)]
    pub(crate) check: bool,
    #[command(flatten)]
    pub(crate) changes: ChangeArgs,
}

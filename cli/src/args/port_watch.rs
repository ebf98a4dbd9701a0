//! `baudbot port watch`.

use clap::Args;

use super::ConnectArgs;
use super::value::whole;

#[derive(Debug, Args)]
pub(crate) struct WatchPortArgs {
    #[command(flatten)]
    pub(crate) server: ConnectArgs,
    /// The cable: the robot's, or a sensor's own [default: that of the only robot]
    #[arg(value_name = "ROBOT[/SENSOR]", default_value = "", hide_default_value = true)]
    pub(crate) cable: String,
    /// End after this many rows
    #[arg(long, value_name = "ROWS", value_parser = whole(0_u64..=u64::MAX))]
    pub(crate) rows: Option<u64>,
}

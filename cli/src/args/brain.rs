//! The options of `baudbot brain`.

use baudbot_client::Reconnect;
use clap::Args;

use super::ConnectArgs;
use super::value::whole;

#[derive(Debug, Args)]
pub(crate) struct BrainArgs {
    /// Name of a brain or of its description file in TOML, with parameters if needed
    #[arg(value_name = "BRAIN[:K=V,…]")]
    pub(crate) brain: Option<String>,
    /// List the brains and their parameters
    #[arg(long)]
    pub(crate) list: bool,
    /// List the brains as JSON
    #[arg(long, conflicts_with = "brain")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) server: ConnectArgs,
    /// A robot to drive, or robots by a pattern such as 'cell-*'; may be given several times [default: the world's only robot]
    #[arg(
        long = "robot",
        value_name = "ROBOT",
        env = "BAUDBOT_ROBOT",
        value_delimiter = ',',
        hide_env_values = true
    )]
    pub(crate) robots: Vec<String>,
    /// Seed of the brain's own random numbers
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(0_u64..=u64::MAX), env = "BAUDBOT_SEED", hide_env_values = true)]
    pub(crate) seed: u64,
    /// After a lost connection, try to reconnect for this time, in seconds; `off` disables reconnection
    #[arg(
        long,
        value_name = "S|off",
        default_value = "600",
        env = "BAUDBOT_RECONNECT_S",
        hide_env_values = true
    )]
    pub(crate) reconnect: Reconnect,
}

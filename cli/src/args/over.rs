//! The connection of the brains of `baudbot run` with their world.

use clap::ValueEnum;
use serde::Serialize;

use baudbot_run::assignment;
use baudbot_run::programs::EXEC;

use super::{PaceName, RunArgs};
use crate::error::Refused;
use crate::logs;

/// The connection of brains with their world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Over {
    /// The world and its brains take turns on one thread
    Direct,
    /// The brains attach to a server in this process, as brains in other programs do
    Grpc,
}

impl RunArgs {
    /// The connection of the brains with their world: as asked for, or else directly, unless something needs the server.
    pub(crate) fn over(&self) -> anyhow::Result<Over> {
        self.over_if(logs::exports())
    }

    fn over_if(&self, exports: bool) -> anyhow::Result<Over> {
        match (self.over, self.needs_server(exports)) {
            (Some(Over::Direct), Some(option)) => Err(Refused::error(format!(
                "--over direct and {option} exclude each other: {option} needs a server, and a direct connection has none; \
                 leave out one of the two"
            ))),
            (Some(over), _) => Ok(over),
            (None, Some(_)) => Ok(Over::Grpc),
            (None, None) => Ok(Over::Direct),
        }
    }

    /// The option that only a server can serve.
    fn needs_server(&self, exports: bool) -> Option<&'static str> {
        let (listen, watchdog) = (&self.listen, &self.watchdog);
        let pace = match self.pace {
            PaceName::Lockstep => None,
            PaceName::Timed(1.0) => Some("--pace real-time"),
            PaceName::Timed(_) => Some("--pace scaled"),
            // A brain on the same thread has always answered.
            PaceName::Free => Some("--pace free"),
        };
        let options = [
            (self.external.is_some(), "--external"),
            (self.brains.iter().any(|brain| assignment::split(brain).1.starts_with(EXEC)), "--brain exec:"),
            // Nobody can interrupt a brain on the same thread, and the world cannot run ahead of it.
            (self.brain_timeout.is_some(), "--brain-timeout"),
            (watchdog.watchdog_ms.is_some(), "--watchdog-ms"),
            (watchdog.on_timeout.is_some(), "--on-timeout"),
            (watchdog.lookahead.is_some(), "--lookahead"),
            (exports, logs::ENDPOINT),
        ];
        pace.or_else(|| listen.given())
            .or_else(|| options.into_iter().find(|(is_asked, _)| *is_asked).map(|(_, option)| option))
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::{Cli, Command};

    fn over(options: &str) -> Result<Over, String> {
        let words = ["baudbot", "run"].into_iter().chain(options.split_whitespace());
        let Some(Command::Run(args)) = Cli::try_parse_from(words).unwrap().command else { panic!() };
        args.over_if(false).map_err(|error| error.to_string())
    }

    #[test]
    fn what_needs_a_server_goes_over_grpc() {
        for options in
            ["", "--viewer off", "--record a.mcap", "--csv a --timeline b --json --quiet", "--over direct"]
        {
            assert_eq!(over(options), Ok(Over::Direct), "{options}");
        }
        for options in [
            "--over grpc",
            "--pace real-time",
            "--pace scaled:2",
            "--pace free",
            "--listen 127.0.0.1:0",
            "--viewer 127.0.0.1:0",
            "--open",
            "--tokens tokens.toml",
            "--max-connections 3",
            "--watchdog-ms 5",
            "--on-timeout wait",
            "--lookahead off",
            "--external 2",
            "--brain exec:./follow.py",
            "--brain alice=exec:./follow.py",
        ] {
            assert_eq!(over(options), Ok(Over::Grpc), "{options}");
        }
    }

    #[test]
    fn what_excludes_each_other_is_told_with_both_names() {
        let error = over("--over direct --listen 127.0.0.1:0").unwrap_err();
        let expected = "--over direct and --listen exclude each other: --listen needs a server, and a direct connection \
                        has none; leave out one of the two";
        assert_eq!(error, expected);
        assert!(
            over("--over direct --pace free")
                .unwrap_err()
                .starts_with("--over direct and --pace free exclude")
        );
    }
}

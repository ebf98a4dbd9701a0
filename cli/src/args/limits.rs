//! The part of a server that one client, one address, one caller, and all of them together may have.

use std::str::FromStr;

use baudbot_server::Limits;
use clap::Args;

#[derive(Debug, Default, Args)]
#[command(next_help_heading = super::LIMITS)]
pub(crate) struct LimitArgs {
    /// Maximum number of connections at a time, including pages
    ///
    /// At the limit, a new connection replaces one that has made no request yet or presented no token; if there is none, the new one is refused.
    /// The default is three quarters of the files that the program may have open (`ulimit -Hn`), with at least 32 kept
    /// free, and at most 16,384.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_connections: Option<u32>,
    /// Connections from one address, or of one user over Unix sockets [default: half of all; for this machine, all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_connections_per_address: Option<u32>,
    /// Connections with one token [default: 256; for your own, any number]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_connections_per_token: Option<u32>,
    /// Calls that one connection may have open at a time [default: 4096]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_streams_per_connection: Option<u32>,
    /// Calls that one caller, a token or an address, may have open at a time [default: 1024; for your own programs, any number]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_streams_per_caller: Option<u32>,
    /// Calls that one caller may begin per second; messages in an open stream do not count [default: 2000; for your own programs,
    /// any number]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    max_requests_per_s: Option<u32>,
    /// Worlds [default: 4096]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_worlds: Option<u32>,
    /// Worlds that one caller has created [default: 512; for your own programs, any number]
    #[arg(long, value_name = "N")]
    max_worlds_per_caller: Option<u32>,
    /// Robots in all worlds [default: 1000000]
    #[arg(long, value_name = "N")]
    max_robots: Option<u32>,
    /// Robots in one world [default: 10000]
    #[arg(long, value_name = "N")]
    max_robots_per_world: Option<u32>,
    /// Snapshots of all worlds [default: 65536]
    #[arg(long, value_name = "N")]
    max_snapshots: Option<u32>,
    /// Snapshots of one world; further ones replace the oldest [default: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_snapshots_per_world: Option<u32>,
    /// Memory for scenarios, states and snapshots, such as 500M, 8G or 25% [default: 50% of the machine's, or of its container's]
    #[arg(long, value_name = "SIZE")]
    max_memory: Option<Size>,
    /// Scenarios, states and recordings that are parsed at a time [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_parsing: Option<u32>,
    /// Requests that wait for parsing [default: 256]
    #[arg(long, value_name = "N")]
    max_waiting: Option<u32>,
    /// Refuse to start worlds once those in real time have lagged for this many seconds; 0 for never [default: 3]
    ///
    /// A world lags if it drops time, because it is behind the wall clock by more than its pace allows. Worlds in lockstep are always
    /// started.
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32).range(..=3600))]
    overload_after: Option<u32>,
    /// Data that waits for clients that do not read it [default: 128M]
    ///
    /// Beyond this, the slowest stream of the caller that leaves most unread ends.
    #[arg(long, value_name = "SIZE")]
    max_unread: Option<Size>,
    /// The same for one caller, whose slowest stream then ends [default: 64M; for your own programs, any size]
    #[arg(long, value_name = "SIZE")]
    max_unread_per_caller: Option<Size>,
    /// The same for one stream of an observer, which then misses frames [default: 16M]
    #[arg(long, value_name = "SIZE")]
    max_unread_per_stream: Option<Size>,
}

/// A size of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Size {
    Bytes(u64),
    /// Of what the machine has.
    Percent(u64),
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("must be a size such as 500M, 8G or 25%, is `{text}`");
        let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit());
        let number: u64 = digits.parse().map_err(|_| wrong())?;
        let bytes = |shift: u32| number.checked_shl(shift).filter(|bytes| bytes >> shift == number);
        match &text[digits.len()..] {
            "%" if (1..=100).contains(&number) => return Ok(Self::Percent(number)),
            "K" => bytes(10),
            "M" => bytes(20),
            "G" => bytes(30),
            "T" => bytes(40),
            _ => None,
        }
        .filter(|&bytes| bytes > 0)
        .map(Self::Bytes)
        .ok_or_else(wrong)
    }
}

impl Size {
    fn bytes(self) -> u64 {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Percent(percent) => Limits::share_of_memory(percent),
        }
    }
}

impl LimitArgs {
    /// The limits of a server.
    pub(crate) fn limits(&self) -> Limits {
        let usual = Limits::default();
        let or = |given: Option<u32>, usual: usize| given.map_or(usual, |n| n as usize);
        let some = |given: Option<u32>| given.map(|n| n as usize);
        Limits {
            connections: or(self.max_connections, usual.connections),
            connections_per_address: some(self.max_connections_per_address),
            connections_per_token: some(self.max_connections_per_token),
            streams_per_connection: or(self.max_streams_per_connection, usual.streams_per_connection),
            streams_per_caller: some(self.max_streams_per_caller),
            requests_per_s: self.max_requests_per_s,
            worlds: or(self.max_worlds, usual.worlds),
            worlds_per_caller: some(self.max_worlds_per_caller),
            robots: or(self.max_robots, usual.robots),
            robots_per_world: or(self.max_robots_per_world, usual.robots_per_world),
            snapshots: or(self.max_snapshots, usual.snapshots),
            snapshots_per_world: or(self.max_snapshots_per_world, usual.snapshots_per_world),
            memory_bytes: self.max_memory.map_or(usual.memory_bytes, Size::bytes),
            parsing: or(self.max_parsing, usual.parsing),
            waiting: or(self.max_waiting, usual.waiting),
            overload_after_s: self.overload_after.map_or(usual.overload_after_s, u64::from),
            unread: self.max_unread.map_or(usual.unread, Size::bytes),
            unread_per_caller: self.max_unread_per_caller.map(Size::bytes),
            unread_per_stream: self.max_unread_per_stream.map_or(usual.unread_per_stream, Size::bytes),
        }
    }

    /// An option that was given.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let options = [
            (self.max_connections.is_some(), "--max-connections"),
            (self.max_connections_per_address.is_some(), "--max-connections-per-address"),
            (self.max_connections_per_token.is_some(), "--max-connections-per-token"),
            (self.max_streams_per_connection.is_some(), "--max-streams-per-connection"),
            (self.max_streams_per_caller.is_some(), "--max-streams-per-caller"),
            (self.max_requests_per_s.is_some(), "--max-requests-per-s"),
            (self.max_worlds.is_some(), "--max-worlds"),
            (self.max_worlds_per_caller.is_some(), "--max-worlds-per-caller"),
            (self.max_robots.is_some(), "--max-robots"),
            (self.max_robots_per_world.is_some(), "--max-robots-per-world"),
            (self.max_snapshots.is_some(), "--max-snapshots"),
            (self.max_snapshots_per_world.is_some(), "--max-snapshots-per-world"),
            (self.max_memory.is_some(), "--max-memory"),
            (self.max_parsing.is_some(), "--max-parsing"),
            (self.max_waiting.is_some(), "--max-waiting"),
            (self.overload_after.is_some(), "--overload-after"),
            (self.max_unread.is_some(), "--max-unread"),
            (self.max_unread_per_caller.is_some(), "--max-unread-per-caller"),
            (self.max_unread_per_stream.is_some(), "--max-unread-per-stream"),
        ];
        options.into_iter().find(|(is_given, _)| *is_given).map(|(_, option)| option)
    }
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::*;
    use crate::args::{Cli, Command};

    fn args(words: &[&str]) -> LimitArgs {
        let words = ["baudbot", "serve"].iter().chain(words);
        let Some(Command::Serve(serve)) = Cli::parse_from(words).command else { panic!("serve") };
        serve.listen.limits
    }

    /// The options under the heading of this file.
    fn options() -> Vec<String> {
        let cli = Cli::command();
        let serve = cli.find_subcommand("serve").expect("serve");
        let ours = serve
            .get_arguments()
            .filter(|arg| arg.get_help_heading().is_some_and(|heading| heading.starts_with("Limits")));
        ours.map(|arg| format!("--{}", arg.get_long().expect("an option"))).collect()
    }

    #[test]
    fn sizes_have_a_unit() {
        assert_eq!("500M".parse(), Ok(Size::Bytes(500 << 20)));
        assert_eq!("8G".parse(), Ok(Size::Bytes(8 << 30)));
        assert_eq!("25%".parse(), Ok(Size::Percent(25)));
        for wrong in ["", "8", "G", "0G", "8g", "0%", "101%", "8 G", "99999999999T", "-1G", "1.5G"] {
            let error = wrong.parse::<Size>().unwrap_err();
            assert!(error.starts_with("must be a size such as 500M"), "{wrong}: {error}");
        }
    }

    #[test]
    fn each_option_is_known_as_given_and_changes_a_limit() {
        let options = options();
        assert_eq!(options.len(), 19, "{options:?}");
        assert_eq!((args(&[]).given(), args(&[]).limits()), (None, Limits::default()));
        for option in &options {
            let is_size = option == "--max-memory" || option.starts_with("--max-unread");
            let value = if is_size { "7M" } else { "7" };
            let args = args(&[option, value]);
            assert_eq!(args.given(), Some(&**option));
            assert_ne!(args.limits(), Limits::default(), "{option}");
        }
    }

    #[test]
    fn the_page_of_limits_has_these_options() {
        let page = include_str!("../../../docs/reference/limits.md");
        let rows = page.lines().filter(|line| line.starts_with('|'));
        let words = rows.flat_map(|line| line.split('`')).filter(|word| word.starts_with("--"));
        let mut told: Vec<_> = words
            .map(|word| word.split(' ').next().unwrap_or_default())
            .filter(|word| word.starts_with("--max") || word.starts_with("--overload"))
            .map(str::to_owned)
            .collect();
        let mut there = options();
        told.sort();
        there.sort();
        assert_eq!(told, there);
    }
}

//! The part of a server that one client, one address, one caller, and all of them together may have: an option for each limit of
//! the server's table.

use std::str::FromStr;

use baudbot_server::{LIMITS, Limit, LimitInfo, Limits, Unit};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, value_parser};

use super::value::{ValueError, whole};

/// The limits that were given, in the order of the table.
#[derive(Debug, Default)]
pub(crate) struct LimitArgs(Vec<(Limit, Given)>);

/// A value that was given.
#[derive(Clone, Copy, Debug)]
enum Given {
    Number(u32),
    Size(Size),
}

/// A size of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Size {
    Bytes(u64),
    /// Of what the machine has.
    Percent(u64),
}

impl FromStr for Size {
    type Err = ValueError;

    fn from_str(text: &str) -> Result<Self, ValueError> {
        let wrong = || ValueError::Text { form: "a size such as 500M, 8G or 25%", text: text.to_owned() };
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

impl Args for LimitArgs {
    fn augment_args(command: Command) -> Command {
        command.args(LIMITS.iter().map(arg))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// The option of a limit.
fn arg(info: &LimitInfo) -> Arg {
    let (first, more) = info.help.split_once("\n\n").unwrap_or((info.help, ""));
    let words = format!("{first} [default: {}]", info.usual_words());
    let arg = Arg::new(info.option).long(info.option.trim_start_matches("--")).help_heading(super::LIMITS);
    let arg = if more.is_empty() { arg } else { arg.long_help(format!("{words}\n\n{more}")) };
    let arg = arg.help(words);
    match info.unit {
        Unit::Things(least, most) => arg.value_name("N").value_parser(whole(least..=most)),
        Unit::Seconds(least, most) => arg.value_name("S").value_parser(whole(least..=most)),
        Unit::Bytes => arg.value_name("SIZE").value_parser(value_parser!(Size)),
    }
}

impl FromArgMatches for LimitArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |info: &LimitInfo| match info.unit {
            Unit::Things(..) | Unit::Seconds(..) => matches.get_one(info.option).copied().map(Given::Number),
            Unit::Bytes => matches.get_one(info.option).copied().map(Given::Size),
        };
        Ok(Self(LIMITS.iter().filter_map(|info| Some((info.limit, given(info)?))).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl LimitArgs {
    /// The limits of a server.
    pub(crate) fn limits(&self) -> Limits {
        self.0.iter().fold(Limits::default(), |limits, &(limit, given)| {
            limits.with(
                limit,
                match given {
                    Given::Number(number) => number.into(),
                    Given::Size(size) => size.bytes(),
                },
            )
        })
    }

    /// An option that was given.
    pub(crate) fn given(&self) -> Option<&'static str> {
        Some(self.0.first()?.0.info().option)
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::args::Cli;

    fn args(words: &[&str]) -> LimitArgs {
        let words = ["baudbot", "serve"].iter().chain(words);
        let Some(crate::args::Command::Serve(serve)) = Cli::parse_from(words).command else {
            panic!("serve")
        };
        serve.listen.limits
    }

    #[test]
    fn sizes_have_a_unit() {
        assert_eq!("500M".parse(), Ok(Size::Bytes(500 << 20)));
        assert_eq!("8G".parse(), Ok(Size::Bytes(8 << 30)));
        assert_eq!("25%".parse(), Ok(Size::Percent(25)));
        for wrong in ["", "8", "G", "0G", "8g", "0%", "101%", "8 G", "99999999999T", "-1G", "1.5G"] {
            let error = wrong.parse::<Size>().unwrap_err().to_string();
            assert!(error.starts_with("must be a size such as 500M"), "{wrong}: {error}");
        }
    }

    #[test]
    fn each_option_is_known_as_given_and_changes_its_limit() {
        assert_eq!((args(&[]).given(), args(&[]).limits()), (None, Limits::default()));
        for info in &LIMITS {
            let (value, number) = if info.unit == Unit::Bytes { ("7M", 7 << 20) } else { ("7", 7) };
            let args = args(&[info.option, value]);
            assert_eq!(args.given(), Some(info.option));
            assert_eq!(args.limits(), Limits::default().with(info.limit, number));
        }
    }

    #[test]
    fn the_page_of_limits_has_these_options() {
        let page = include_str!("../../../docs/reference/limits.md");
        let rows: Vec<_> = page.lines().filter(|line| line.starts_with("| `--")).collect();
        assert_eq!(rows.len(), LIMITS.len());
        for info in &LIMITS {
            let row = rows.iter().find(|row| row.starts_with(&format!("| `{} ", info.option)));
            let row = row.unwrap_or_else(|| panic!("{}", info.option));
            assert!(row.contains(&format!("| `{}` |", info.name)), "{row}");
        }
    }
}

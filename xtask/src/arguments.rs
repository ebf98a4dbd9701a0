//! The request in the arguments of `./test`.

use std::ffi::OsString;

use lexopt::{Arg, Parser};

use crate::sections::{self, Rung, Section};

/// A request.
pub(crate) enum Request {
    /// The text of `--help`.
    Help,
    /// The table of sections.
    List,
    /// The structure of the code, by [`crate::house`], with its arguments.
    House(Vec<String>),
    /// Sections that run.
    Run(Plan),
}

/// Sections, and how they run.
pub(crate) struct Plan {
    /// The sections, in the order of the table.
    pub(crate) sections: Vec<&'static Section>,
    /// The arguments of the one section that takes some.
    pub(crate) arguments: Vec<String>,
    /// The sections and groups that were asked for.
    pub(crate) asked: Vec<String>,
    /// The whole call without `--resume`, for messages that tell how to go on.
    pub(crate) call: Vec<String>,
    /// Tools that are missing are installed.
    pub(crate) install: bool,
    /// Sections that passed on this state of the tree are passed over.
    pub(crate) resume: bool,
    /// A section that fails does not end the run.
    pub(crate) keep_going: bool,
    /// Each section runs so many times.
    pub(crate) repeat: u32,
    /// All processors are kept busy meanwhile.
    pub(crate) load: bool,
    /// The seconds that the sections took become those that are expected.
    pub(crate) write_times: bool,
    /// It is `./test all`: the ages of release checks are judged, too.
    pub(crate) whole: bool,
}

/// A reason why arguments are refused.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// It is not an option, or has no value.
    #[error("{0}")]
    Option(#[from] lexopt::Error),
    /// There is no such section.
    #[error("there is no section `{0}`{1}")]
    Section(String, String),
    /// An argument for one section among several.
    #[error("`{0}` is no section: a section has arguments only if it runs alone")]
    Argument(String),
    /// An option that only the run of whole sections has.
    #[error("--from {0}: this section is not among those that are asked for")]
    From(String),
    /// Times beside a load are not those of an idle machine.
    #[error(
        "--write-times does not go with --load or --repeat: it keeps the times of single runs on an idle machine"
    )]
    Times,
    /// There is nothing to repeat.
    #[error("--repeat {0}: must be a number from 1 to 1000")]
    Repeat(String),
}

impl Request {
    /// The request of the command line.
    ///
    /// # Errors
    ///
    /// It is no call of `./test`.
    pub(crate) fn from_command_line() -> Result<Self, Error> {
        Self::from_words(std::env::args_os().skip(1))
    }

    fn from_words(words: impl IntoIterator<Item = impl Into<OsString>>) -> Result<Self, Error> {
        let mut plan = Plan::new();
        let mut from = None;
        let words: Vec<OsString> = words.into_iter().map(Into::into).collect();
        let call = words.iter().map(|word| word.to_string_lossy().into_owned());
        plan.call = call.filter(|word| word != "--resume").collect();
        let mut parser = Parser::from_args(words);
        while let Some(argument) = parser.next()? {
            match argument {
                Arg::Short('h') | Arg::Long("help") => return Ok(Self::Help),
                Arg::Long("list") => return Ok(Self::List),
                Arg::Long("from") => from = Some(parser.value()?.to_string_lossy().into_owned()),
                Arg::Long("repeat") => {
                    let value = parser.value()?.to_string_lossy().into_owned();
                    plan.repeat =
                        value.parse().ok().filter(|n| (1..=1000).contains(n)).ok_or(Error::Repeat(value))?;
                }
                Arg::Value(word) if word == "help" && plan.asked.is_empty() => return Ok(Self::Help),
                Arg::Value(word) if word == "house" && plan.asked.is_empty() => {
                    let rest = parser.raw_args()?.map(|word| word.to_string_lossy().into_owned());
                    return Ok(Self::House(rest.collect()));
                }
                Arg::Value(word) => plan.word(word.to_string_lossy().into_owned())?,
                Arg::Long(name) if plan.option(name) => {}
                Arg::Long(name) if plan.takes_arguments() => plan.arguments.push(format!("--{name}")),
                Arg::Short(_) | Arg::Long(_) => return Err(argument.unexpected().into()),
            }
        }
        plan.finish(from)?;
        Ok(Self::Run(plan))
    }
}

impl Plan {
    fn new() -> Self {
        Self {
            sections: Vec::new(),
            arguments: Vec::new(),
            asked: Vec::new(),
            call: Vec::new(),
            install: false,
            resume: false,
            keep_going: false,
            repeat: 1,
            load: false,
            write_times: false,
            whole: false,
        }
    }

    /// Takes an option without a value, if it is one.
    fn option(&mut self, name: &str) -> bool {
        let option = match name {
            "install" => &mut self.install,
            "resume" => &mut self.resume,
            "keep-going" => &mut self.keep_going,
            "load" => &mut self.load,
            "write-times" => &mut self.write_times,
            _ => return false,
        };
        *option = true;
        true
    }

    fn takes_arguments(&self) -> bool {
        matches!(&self.sections[..], [only] if !only.arguments.is_empty())
    }

    fn word(&mut self, word: String) -> Result<(), Error> {
        let group = match word.as_str() {
            "all" => Some(Rung::All),
            "release-checks" => Some(Rung::Release),
            _ => None,
        };
        if let Some(rung) = group {
            self.whole |= rung == Rung::All;
            self.sections.extend(sections::up_to(rung));
        } else if self.takes_arguments() && (self.asked == ["quick"] || sections::named(&word).is_none()) {
            // A crate may have the name of a section.
            self.arguments.push(word);
            return Ok(());
        } else if let Some(section) = sections::named(&word) {
            if let Some(argument) = self.arguments.first() {
                return Err(Error::Argument(argument.clone()));
            }
            self.sections.push(section);
        } else {
            let similar = sections::similar(&word);
            return Err(Error::Section(word, similar));
        }
        self.asked.push(word);
        Ok(())
    }

    fn finish(&mut self, from: Option<String>) -> Result<(), Error> {
        if self.write_times && (self.load || self.repeat > 1) {
            return Err(Error::Times);
        }
        if self.asked.is_empty() {
            self.sections = sections::up_to(Rung::Test).collect();
        }
        self.sections.sort_by_key(|section| section.place());
        self.sections.dedup_by_key(|section| section.name);
        if let Some(from) = from {
            let first = self.sections.iter().position(|section| section.name == from);
            self.sections.drain(..first.ok_or(Error::From(from))?);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Plan, Request};

    fn plan(words: &[&str]) -> Plan {
        match Request::from_words(words) {
            Ok(Request::Run(plan)) => plan,
            Ok(_) => panic!("{words:?} runs nothing"),
            Err(error) => panic!("{words:?}: {error}"),
        }
    }

    fn refused(words: &[&str]) -> String {
        match Request::from_words(words) {
            Ok(_) => panic!("{words:?} is taken"),
            Err(error) => error.to_string(),
        }
    }

    fn names(words: &[&str]) -> Vec<&'static str> {
        plan(words).sections.iter().map(|section| section.name).collect()
    }

    #[test]
    fn all_begins_with_what_a_contributor_runs() {
        let (short, all) = (names(&[]), names(&["all"]));
        assert!(short.len() > 4 && all.len() > short.len() + 20, "{short:?} {all:?}");
        assert_eq!(all[..short.len()], short);
        assert!(plan(&["all"]).whole && !plan(&[]).whole);
    }

    #[test]
    fn sections_run_in_the_order_of_the_table_and_once() {
        assert_eq!(names(&["lints", "formatting", "lints"]), ["formatting", "lints"]);
        let late = names(&["all", "--from", "lints"]);
        assert_eq!(late[0], "lints");
        assert_eq!(
            late.len(),
            names(&["all"]).len() - names(&["all"]).iter().position(|name| *name == "lints").unwrap()
        );
    }

    #[test]
    fn a_section_that_takes_arguments_gets_what_follows() {
        let network = plan(&["network", "--seed", "2347", "--repeat", "3"]);
        assert_eq!((network.arguments, network.repeat), (vec!["--seed".to_owned(), "2347".to_owned()], 3));
        assert_eq!(plan(&["quick", "sim", "wire"]).arguments, ["sim", "wire"]);
    }

    #[test]
    fn what_is_no_section_is_refused_with_those_that_are_like_it() {
        assert_eq!(refused(&["lint"]), "there is no section `lint`; did you mean `lints`?");
        assert_eq!(refused(&["xyzzy"]), "there is no section `xyzzy`; ./test --list has them all");
        assert!(refused(&["lints", "--from", "tests"]).contains("not among those"));
        assert!(refused(&["lints", "--repeat", "0"]).contains("from 1 to 1000"));
        assert!(refused(&["lints", "--load", "--write-times"]).contains("idle machine"));
        assert!(refused(&["lints", "--quickly"]).contains("--quickly"));
        assert!(refused(&["network", "500", "lints"]).contains("runs alone"));
        assert_eq!(names(&["kills", "soak"]), ["kills", "soak"]);
        assert_eq!(plan(&["quick", "page"]).arguments, ["page"]);
        assert_eq!(plan(&["all", "--resume", "--keep-going"]).call, ["all", "--keep-going"]);
    }
}

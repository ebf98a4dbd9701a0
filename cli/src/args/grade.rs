//! The arguments of `baudbot grade`.

use std::path::PathBuf;

use clap::Args;

use super::value::whole;

#[derive(Debug, Args)]
pub(crate) struct GradeArgs {
    /// A built-in exercise, or an exercise file (docs/how-to/grading.md); without one, lists the built-in ones
    pub(crate) exercise: Option<String>,
    /// The brain to grade, for one robot, or for all robots that no other --brain names
    ///
    /// BRAIN is a name, a brain's description file in TOML, or `exec:PROGRAM ARGUMENTS…`, a program of your own, as for `baudbot run`.
    #[arg(long = "brain", value_name = "[ROBOT=]BRAIN[:K=V,…]")]
    pub(crate) brains: Vec<String>,
    /// Grade each brain of a class: a folder of brains, or several files and folders
    ///
    /// A brain is a file NAME.toml or NAME.py, a program, or a folder with brain.toml or brain.py. The result is a table with one row
    /// per brain, under its file's or folder's name.
    #[arg(long, value_name = "PATH", num_args = 1.., requires = "exercise", conflicts_with_all = ["list", "show", "toml"])]
    pub(crate) class: Vec<PathBuf>,
    /// Command that runs the programs of a class, such as 'exec:.venv/bin/python {}' [default: python3 for Python, others directly]
    #[arg(long, value_name = "exec:COMMAND {}", requires = "class")]
    pub(crate) with: Option<String>,
    /// Write the table of a class as CSV; `-` is stdout
    #[arg(long, value_name = "FILE", requires = "class")]
    pub(crate) csv: Option<PathBuf>,
    /// Set a parameter of all brains that have it; programs get it in the environment variable BAUDBOT_PARAMETERS
    #[arg(long = "parameter", value_name = "NAME=VALUE")]
    pub(crate) parameters: Vec<String>,
    /// List the built-in exercises
    #[arg(long, conflicts_with_all = ["exercise", "brains", "show"])]
    pub(crate) list: bool,
    /// Show the exercise's task and the criteria that earn points, without grading anything
    #[arg(long, requires = "exercise", conflicts_with = "brains")]
    pub(crate) show: bool,
    /// Print the file of a built-in exercise, as a starting point for your own
    #[arg(long, requires = "exercise", conflicts_with_all = ["brains", "show"])]
    pub(crate) toml: bool,
    /// Seeds in place of the exercise's: N (1 to N), A..B (inclusive) or A,B,C
    #[arg(long, value_name = "SEEDS")]
    pub(crate) seeds: Option<String>,
    /// Number of parallel runs [default: the number of processors]
    #[arg(long, value_name = "N", value_parser = whole(1_u16..=1024))]
    pub(crate) jobs: Option<u16>,
    /// Pass the output of brains that are programs on to stderr [default: only the last lines of a brain that fails]
    #[arg(long)]
    pub(crate) show_output: bool,
    /// Write the result as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// Write the result as JUnit XML, for continuous integration; `-` is stdout
    #[arg(long, value_name = "FILE")]
    pub(crate) junit: Option<PathBuf>,
    /// Suppress the progress bar and the text (JSON is still written)
    #[arg(long)]
    pub(crate) quiet: bool,
}

pub(super) const EXAMPLES: &str = "\
Examples:
  baudbot grade                                  the exercises
  baudbot grade wander --show                    the task of one
  baudbot grade wander --toml > my.toml          an exercise file, to be changed
  baudbot grade wander --brain 'exec:python3 brain.py'
  baudbot grade wander --brain avoid --json --quiet
  baudbot grade my.toml --brain brain.toml --junit result.xml
  baudbot grade wander --class homework --csv points.csv    all brains in a folder

Exit codes:
  0    passed, or nothing to grade
  1    not graded: the brain drove in no run, or an error occurred
  2    the exercise, the brain or the options cannot be used
  3    graded, but not passed; for a class: not passed by every brain
  130  stopped by Ctrl-C";

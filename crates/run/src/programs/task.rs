//! The task for which a program is started.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::programs::program::Program;

/// A program, and the robots that it is to drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// The program.
    pub program: Program,
    /// Names of the robots.
    pub robots: Vec<String>,
    /// The program's parameters by name, beside those among its arguments.
    pub parameters: BTreeMap<String, Value>,
    /// The lifetime of a process of it.
    pub lifetime: Lifetime,
    /// The destination of its output.
    pub output: Output,
    /// Further variables of its environment, in place of those of the same name.
    pub variables: BTreeMap<String, String>,
}

/// The destination of a program's output. Its end is always kept, and shown if the program fails.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Output {
    /// The output is only kept.
    #[default]
    Kept,
    /// The output goes to standard error as it comes, too.
    Shown,
}

/// The lifetime of a program's process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lifetime {
    /// The program lives for one run.
    #[default]
    Run,
    /// The program lives for many runs, one after the other. The environment has the first. Each line of its standard
    /// input is another: a JSON object with the variables that have changed. The end of its input ends it.
    ManyRuns,
}

impl Task {
    /// A program for these robots: a process a run, without parameters, whose output is only kept.
    pub fn new(program: Program, robots: Vec<String>) -> Self {
        let parameters = BTreeMap::new();
        let variables = BTreeMap::new();
        Self { program, robots, parameters, lifetime: Lifetime::Run, output: Output::Kept, variables }
    }

    /// The variables that the program finds in its environment: where it attaches, to which world, as which robots (names with
    /// commas between them), with which seed and parameters (JSON). It is not to come back to a server that it loses, since its
    /// run is then over. `BAUDBOT_REUSE` is 1 if it is to read further runs from its standard input, and else empty.
    pub fn environment(&self, connect: &str, world: &str, seed: u64) -> [(&'static str, String); 7] {
        let parameters = serde_json::to_string(&self.parameters).expect("names are texts");
        [
            ("BAUDBOT_CONNECT", connect.to_owned()),
            ("BAUDBOT_WORLD", world.to_owned()),
            ("BAUDBOT_ROBOT", self.robots.join(",")),
            ("BAUDBOT_SEED", seed.to_string()),
            ("BAUDBOT_PARAMETERS", parameters),
            ("BAUDBOT_RECONNECT_S", "0".to_owned()),
            ("BAUDBOT_REUSE", if self.lifetime == Lifetime::ManyRuns { "1" } else { "" }.to_owned()),
        ]
    }
}

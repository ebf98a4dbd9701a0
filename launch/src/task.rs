//! What a program is started for.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::program::Program;

/// A program, and the robots that it is to drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// The program.
    pub program: Program,
    /// Names of the robots.
    pub robots: Vec<String>,
    /// Its parameters by name, beside those among its arguments.
    pub parameters: BTreeMap<String, Value>,
}

impl Task {
    /// The variables that the program finds in its environment: where it attaches, to which world, as which robots (names with
    /// commas between them), with which seed and parameters (JSON). It is not to come back to a server that it loses, since its
    /// run is then over.
    pub fn environment(&self, connect: &str, world: &str, seed: u64) -> [(&'static str, String); 6] {
        let parameters = serde_json::to_string(&self.parameters).expect("names are texts");
        [
            ("BAUDBOT_CONNECT", connect.to_owned()),
            ("BAUDBOT_WORLD", world.to_owned()),
            ("BAUDBOT_ROBOT", self.robots.join(",")),
            ("BAUDBOT_SEED", seed.to_string()),
            ("BAUDBOT_PARAMETERS", parameters),
            ("BAUDBOT_RECONNECT_S", "0".to_owned()),
        ]
    }
}

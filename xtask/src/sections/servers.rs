//! Sections of servers before strangers, and as they are deployed.

use super::parts::{python, script};
use super::rust::built;
use crate::shell::{Failure, Shell};

/// Clients of others, by TLS, and another user of the machine, before a server that asks for tokens.
pub(super) fn strangers(shell: &Shell) -> Result<(), Failure> {
    beside_the_program(shell, "tests/trust/strangers.py")
}

/// The unit, the manifest, and servers with their arguments.
pub(super) fn deployment(shell: &Shell) -> Result<(), Failure> {
    beside_the_program(shell, "tests/trust/deployment.py")?;
    beside_the_program(shell, "tests/trust/proxy.py")
}

fn beside_the_program(shell: &Shell, file: &str) -> Result<(), Failure> {
    let python = python(shell)?;
    let program = built(shell)?;
    shell.run(script(shell, &python, &[file, &program.to_string_lossy()]))
}

//! The brain `navigate` as a program of its own.

use std::process::ExitCode;

fn main() -> ExitCode {
    baudbot_brains::program::main("navigate")
}

//! `baudbot new`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

#[derive(Debug, Subcommand)]
pub(crate) enum NewCommand {
    /// Creates a project with a brain that attaches to a robot and drives it
    #[command(after_long_help = EXAMPLES)]
    Brain(NewBrainArgs),
    /// Creates a project with a program for a robot's microcontroller: a sketch, a makefile and a robot
    #[command(after_long_help = FIRMWARE_EXAMPLES)]
    Firmware(NewFirmwareArgs),
}

#[derive(Debug, Args)]
pub(crate) struct NewBrainArgs {
    /// The project's folder, which must be new or empty; its name is the project's name
    pub(crate) folder: PathBuf,
    /// Programming language
    #[arg(long, value_name = "LANGUAGE", default_value = "rust")]
    pub(crate) lang: Language,
    /// For Rust: use the crates of a clone of baudbot, in this folder [default: the project contains them]
    #[arg(long, value_name = "DIR")]
    pub(crate) baudbot: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct NewFirmwareArgs {
    /// The project's folder, which must be new or empty; its name is the program's name
    pub(crate) folder: PathBuf,
    /// Programming language
    #[arg(long, value_name = "LANGUAGE", default_value = "arduino")]
    pub(crate) lang: FirmwareLanguage,
}

/// The language of a program for a microcontroller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FirmwareLanguage {
    /// A sketch in Arduino's C++, with the Arduino core
    Arduino,
    /// C, using the chip's registers
    C,
}

/// The language of a project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Language {
    /// A brain made of baudbot's behaviours and one of its own
    Rust,
    /// A brain on the package `baudbot-client`, whose files the project contains
    Python,
    /// A wall follower in C++, by Debian's gRPC
    Cpp,
    /// A wall follower in Go, by Debian's gRPC
    Go,
    /// A wall follower in Java, by Debian's gRPC
    Java,
    /// A wall follower in Ruby, by Debian's gRPC
    Ruby,
    /// A wall follower for Node.js, without generated code
    Node,
    /// A wall follower in TypeScript
    #[value(name = "typescript")]
    TypeScript,
}

const FIRMWARE_EXAMPLES: &str = "\
Examples:
  baudbot new firmware rover                     a sketch for an Arduino Uno
  baudbot new firmware rover --lang c            the same in C
  cd rover && make && make run                   builds and runs it";

const EXAMPLES: &str = "\
Examples:
  baudbot new brain weaver                       a brain of behaviours in Rust
  baudbot new brain timid --lang python          a brain in Python
  baudbot new brain follow --lang cpp            one in C++; its README has the packages that it needs";

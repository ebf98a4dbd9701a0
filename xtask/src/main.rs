//! The ladder of tests: `./test` and `cargo xtask`.
//!
//! 1. [`arguments`] reads what is asked for.
//! 2. [`sections`] is the table of all sections: what each protects, what it needs, and the function that runs it.
//! 3. [`needs`] looks for the tools that they need, and installs them if that is asked for.
//! 4. [`ladder`] runs sections one after the other, and sums up. [`shell`] starts their programs, [`records`] keeps how long
//!    they take and which have passed.
//! 5. [`house`] measures the structure of the code, and [`map`] draws its crates; [`notices`] collects those of others' work for what is given away.

mod arguments;
mod house;
mod ladder;
mod list;
mod map;
mod needs;
mod notices;
mod place;
mod records;
mod sections;
mod shell;
mod temporary;

use std::process::ExitCode;

use arguments::Request;

fn main() -> ExitCode {
    let request = match Request::from_command_line() {
        Ok(request) => request,
        Err(error) => {
            eprintln!("{error}; ./test --help says how it is called");
            return ExitCode::from(2);
        }
    };
    match request {
        Request::Help => {
            print!("{}", list::HELP);
            ExitCode::SUCCESS
        }
        Request::List => shown(list::print()),
        Request::House(arguments) => match house::run(&arguments) {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::FAILURE,
            Err(error) => refused(&error),
        },
        Request::Run(plan) => match ladder::run(&plan) {
            Ok(code) => code,
            Err(shell::Failure::Interrupted) => ExitCode::from(130),
            Err(error) => refused(&error),
        },
    }
}

fn shown(result: Result<(), records::Error>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => refused(&error),
    }
}

fn refused(error: &dyn std::error::Error) -> ExitCode {
    eprintln!("{error}");
    ExitCode::from(2)
}

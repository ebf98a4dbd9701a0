//! From the description of a program to what the system needs to start it.

use std::env;
use std::ffi::{CString, OsStr, OsString};
use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::{AsRawFd, OwnedFd};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::os::spawn::Launch;
use crate::program::{Output, Program};

/// Libraries that compute with threads of their own let them wait in loops, which takes for ever while one task runs at a time.
const ONE_THREAD: [&str; 3] = ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"];

/// All that the system needs, and the program's outputs as /proc shows their descriptors.
pub(crate) fn launch(program: &Program, shown: &[i64]) -> Result<(Launch, Vec<PathBuf>), Error> {
    let first = program.words.first().ok_or(Error::NoWords)?;
    let environment = environment(program);
    let path = environment.iter().find(|(name, _)| name == "PATH").map(|(_, value)| value.clone());
    let file = find(first, program, &path.unwrap_or_default())?;
    let folder = folder(program);
    let failed = |source| Error::Start { program: name(program), source };
    let streams = [
        Some(OwnedFd::from(File::open("/dev/null").map_err(failed)?)),
        stream(&program.output).map_err(failed)?,
        stream(&program.errors).map_err(failed)?,
    ];
    let outputs = [(&streams[1], 1), (&streams[2], 2)]
        .into_iter()
        .filter_map(|(stream, own)| {
            let number = stream.as_ref().map_or(own, AsRawFd::as_raw_fd);
            std::fs::read_link(format!("/proc/self/fd/{number}")).ok()
        })
        .collect();
    let lines = environment.into_iter().map(|(mut line, value)| {
        line.push("=");
        line.push(value);
        text(&line)
    });
    let launch = Launch {
        file: text(file.as_os_str())?,
        words: program.words.iter().map(|word| text(word)).collect::<Result<_, _>>()?,
        environment: lines.collect::<Result<_, _>>()?,
        folder: text(folder.as_os_str())?,
        streams,
        filter: crate::os::filter::program(shown),
    };
    Ok((launch, outputs))
}

/// The name by which errors call a program that does not run yet.
pub(crate) fn name(program: &Program) -> String {
    program.words.first().map_or_else(String::new, |word| word.to_string_lossy().into_owned())
}

fn text(text: &OsStr) -> Result<CString, Error> {
    CString::new(text.as_bytes()).map_err(|_| Error::Text {
        text: text.to_string_lossy().into_owned(),
        problem: "has a zero byte in it, which no program can be given",
    })
}

/// In a fixed order, so that the program's memory is the same each time.
fn environment(program: &Program) -> Vec<(OsString, OsString)> {
    let mut all: std::collections::BTreeMap<OsString, OsString> =
        ONE_THREAD.iter().map(|name| (OsString::from(name), OsString::from("1"))).collect();
    all.extend(env::vars_os());
    all.extend(program.environment.iter().cloned());
    all.into_iter().collect()
}

fn find(word: &OsStr, program: &Program, path: &OsStr) -> Result<PathBuf, Error> {
    if word.as_bytes().contains(&b'/') {
        return Ok(word.into());
    }
    let is_program = |file: &PathBuf| {
        let file = folder(program).join(file);
        file.metadata().is_ok_and(|facts| facts.is_file() && facts.permissions().mode() & 0o111 != 0)
    };
    env::split_paths(path)
        .map(|folder| folder.join(word))
        .find(is_program)
        .ok_or_else(|| Error::NoProgram { program: word.to_string_lossy().into_owned() })
}

/// The folder it runs in.
fn folder(program: &Program) -> &Path {
    program.folder.as_deref().unwrap_or_else(|| Path::new("."))
}

fn stream(output: &Output) -> io::Result<Option<OwnedFd>> {
    match output {
        Output::Inherited => Ok(None),
        Output::Discarded => Ok(Some(OpenOptions::new().write(true).open("/dev/null")?.into())),
        Output::Given(stream) => Ok(Some(stream.try_clone()?.into())),
    }
}

//! The sources that the program carries for projects: the crates that a brain in Rust needs, and the package for
//! Python. The build script (`build/main.rs`) packs them.

use std::io::Read;

use anyhow::Context;

/// Files for a project in this language: their paths in it, and their bytes.
pub(super) fn of(language: &str) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let files = files().context("the program's own sources are damaged")?;
    let own = |(path, file): (String, Vec<u8>)| {
        let path = path.strip_prefix(language)?.strip_prefix('/')?;
        Some((path.to_owned(), file))
    };
    Ok(files.into_iter().filter_map(own).collect())
}

fn files() -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut bytes = Vec::new();
    lz4::Decoder::new(PACKED)?.read_to_end(&mut bytes)?;
    let (mut files, mut rest) = (Vec::new(), bytes.as_slice());
    while !rest.is_empty() {
        let path = line(&mut rest)?.to_owned();
        let length = line(&mut rest)?.parse()?;
        let (file, after) = rest.split_at_checked(length).context("a file is cut off")?;
        files.push((path, file.to_vec()));
        rest = after;
    }
    Ok(files)
}

fn line<'a>(rest: &mut &'a [u8]) -> anyhow::Result<&'a str> {
    let end = rest.iter().position(|byte| *byte == b'\n').context("a line has no end")?;
    let line = std::str::from_utf8(&rest[..end])?;
    *rest = &rest[end + 1..];
    Ok(line)
}

const PACKED: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/sources.lz4"));

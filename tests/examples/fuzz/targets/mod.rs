//! The targets.

mod access;
mod dialogues;
mod files;
mod programs;
mod wire;
mod worlds;

/// Reads bytes, and returns a number for the path through the code: equal for equal paths.
pub(crate) type Run = Box<dyn FnMut(&[u8]) -> u64>;

/// Something that reads bytes from outside.
pub(crate) struct Target {
    pub(crate) name: &'static str,
    pub(crate) what: &'static str,
    /// Sound inputs to begin with.
    pub(crate) seeds: Vec<Vec<u8>>,
    /// The words of such inputs.
    pub(crate) words: &'static [&'static [u8]],
    pub(crate) run: Run,
}

impl Target {
    /// The number of inputs to try before a release: a protocol's are short, and each of the others is a file or a run.
    pub(crate) fn wanted(&self) -> u64 {
        if wire::NAMES.contains(&self.name) { 100_000_000 } else { 1_000_000 }
    }
}

/// All targets.
pub(crate) fn all() -> anyhow::Result<Vec<Target>> {
    let mut targets = wire::targets();
    targets.extend(access::targets());
    targets.extend(dialogues::targets()?);
    targets.extend(files::targets()?);
    targets.extend(programs::targets()?);
    targets.extend(worlds::targets()?);
    Ok(targets)
}

/// The outcome of something, by its words: numbers in them make no difference.
fn outcome(words: &str) -> u64 {
    let plain = words.bytes().filter(|byte| !byte.is_ascii_digit());
    plain.fold(7, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

//! Fingerprints, which distinguish two experiments, and two builds of the program.

use std::fmt::Write;

use baudbot_brains::catalogue;
use baudbot_run::assignment;
use baudbot_run::in_process::InProcess;
use baudbot_run::programs::Lifetime;
use baudbot_server::world_status;

use crate::experiment::Experiment;
use crate::figures::INFOS;
use crate::run_record::Ran;

/// Equal for experiments whose runs are the same, run by run. Reports and charts make no difference.
pub(crate) fn fingerprint(experiment: &Experiment) -> String {
    fingerprint_with(experiment, "")
}

/// The same of experiments of which runs depend on something else, too.
pub(crate) fn fingerprint_with(experiment: &Experiment, own: &str) -> String {
    let Experiment { text, brains, seconds, seeds, design, fields, .. } = experiment;
    let choices: Vec<_> = fields.iter().map(|field| &field.choice).collect();
    let figures = INFOS.map(|info| info.name);
    // A described brain may be described in another way tomorrow.
    let described =
        brains.iter().map(|brain| catalogue::described(assignment::split(brain).1).ok().flatten());
    let described: Vec<_> = described.collect();
    let mut hash = Hash(OFFSET);
    let _ = write!(hash, "{:?}", (text, brains, described, seconds, seeds, design, choices, figures));
    let _ = write!(hash, "{own}");
    // Runs of processes that do many are to be the same, and sometimes are not.
    if experiment.lifetime == Lifetime::ManyRuns {
        let _ = write!(hash, "many runs");
    }
    format!("{:032x}", hash.0)
}

/// The version, and the fingerprints of a second of two scenarios here. Builds with the same are taken to run an
/// experiment in the same way; those whose model, default brain or figures differ have others, but for devices that
/// neither of the two has.
pub(crate) fn build() -> String {
    let mut hash = Hash(OFFSET);
    for text in PROBES {
        let scenario =
            baudbot_scenario::parse(text).expect("it is part of the program, and its tests read it");
        let mut local = InProcess::new(scenario, assignment::DEFAULT).expect("its only robot has IR sensors");
        local.run(PROBE_TICKS);
        let _ = write!(hash, "{:?}", Ran::of(&world_status(&local.world)));
    }
    format!("{} {:016x}", env!("CARGO_PKG_VERSION"), hash.0 as u64)
}

/// 128-bit FNV-1a.
struct Hash(u128);

impl Write for Hash {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u128::from(byte)).wrapping_mul(PRIME);
        }
        Ok(())
    }
}

const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

const PROBES: [&str; 2] = [
    include_str!("../../../catalogue/scenarios/wander.toml"),
    include_str!("../../../catalogue/scenarios/khepera.toml"),
];
const PROBE_TICKS: u64 = 100;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_always_says_the_same_of_itself_and_knows_quickly() {
        let start = std::time::Instant::now();
        let first = build();
        assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
        assert_eq!(first, build());
        assert!(first.starts_with(concat!(env!("CARGO_PKG_VERSION"), " ")), "{first}");
    }
}

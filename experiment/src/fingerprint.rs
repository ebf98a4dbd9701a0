//! What tells two experiments apart.

use std::fmt::Write;

use crate::experiment::Experiment;
use crate::figures::INFOS;

/// Equal for experiments whose runs are the same, run by run. What is only told or drawn of the runs makes no difference.
pub(crate) fn fingerprint(experiment: &Experiment) -> String {
    let Experiment { text, brains, seconds, seeds, design, fields, .. } = experiment;
    let choices: Vec<_> = fields.iter().map(|field| &field.choice).collect();
    let figures = INFOS.map(|info| info.name);
    let mut hash = Hash(OFFSET);
    let version = env!("CARGO_PKG_VERSION");
    let _ = write!(hash, "{:?}", (version, text, brains, seconds, seeds, design, choices, figures));
    format!("{:032x}", hash.0)
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

//! Fields of a scenario that are drawn anew for each run.

use baudbot_scenario::Override;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use crate::learn::error::LearnError;

/// A field that is varied.
#[derive(Clone, Debug, PartialEq)]
pub struct Varied {
    /// The path of the field, as for `--set`.
    pub path: String,
    /// The draw of its values.
    pub draw: Draw,
}

/// The distribution of a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Draw {
    /// A number of [low, high), each as likely.
    Uniform {
        /// The least.
        low: f64,
        /// The limit.
        high: f64,
    },
    /// A number of [low, high), whose logarithm is uniform.
    LogUniform {
        /// The least, above 0.
        low: f64,
        /// The limit.
        high: f64,
    },
    /// A whole number of [low, high], each as likely.
    Integer {
        /// The least.
        low: i64,
        /// The greatest.
        high: i64,
    },
    /// One of these, in TOML, each as likely.
    Choice(Vec<String>),
}

impl Varied {
    /// Checks that there is something to draw from.
    ///
    /// # Errors
    /// If a range is empty or not finite, or there is no choice.
    pub fn check(&self) -> Result<(), LearnError> {
        let wrong = |problem: String| Err(LearnError::value(format!("randomize.{}", self.path), problem));
        match &self.draw {
            Draw::Uniform { low, high } if !(low.is_finite() && high.is_finite() && low <= high) => {
                wrong(format!("[{low}, {high}] is not a range of finite numbers"))
            }
            Draw::LogUniform { low, high } if !(*low > 0.0 && high.is_finite() && low <= high) => {
                wrong(format!("[{low}, {high}] is not a range of finite numbers above 0"))
            }
            Draw::Integer { low, high } if low > high => wrong(format!("[{low}, {high}] is empty")),
            Draw::Choice(all) if all.is_empty() => wrong("there is nothing to choose from".to_owned()),
            Draw::Uniform { .. } | Draw::LogUniform { .. } | Draw::Integer { .. } | Draw::Choice(_) => Ok(()),
        }
    }

    /// The change of the scenario for a run with this seed: a function of both the seed and the field's path, so that no field
    /// depends on which others are varied.
    pub(crate) fn of_run(&self, seed: u64) -> Result<Override, baudbot_scenario::ScenarioError> {
        let stream =
            self.path.bytes().fold(FNV_OFFSET, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(FNV_PRIME));
        let mut random = Pcg64::seed_from_u64(seed ^ stream);
        let value = match &self.draw {
            Draw::Uniform { low, high } => format!("{:?}", low + (high - low) * unit(&mut random)),
            Draw::LogUniform { low, high } => {
                let exponent = baudbot_geometry::math::ln(high / low) * unit(&mut random);
                format!("{:?}", low * baudbot_geometry::math::exp(exponent))
            }
            Draw::Integer { low, high } => {
                let count = (i128::from(*high) - i128::from(*low) + 1) as u128;
                let number = (u128::from(random.next_u64()) * count) >> 64;
                format!("{}", i128::from(*low) + number as i128)
            }
            Draw::Choice(all) => {
                let place = (u128::from(random.next_u64()) * all.len() as u128) >> 64;
                all[place as usize].clone()
            }
        };
        Override::parse(&format!("{}={value}", self.path))
    }
}

/// A number of [0, 1).
fn unit(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0100_0000_01b3;

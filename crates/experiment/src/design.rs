//! The combinations of the fields' values that are run, without a list of them.

use baudbot_sim::random::Stream;

use crate::error::Error;
use crate::factor::{Choice, Field, Level};
use crate::raw::Kind;

/// The set of combinations. Each has a number, by which it is made.
#[derive(Clone, Debug, PartialEq)]
pub enum Design {
    /// Every value of a field with every one of the others; the last field changes first.
    Grid,
    /// The first values of all fields, then the second, and so on.
    List,
    /// The values are drawn at random.
    Random {
        /// The number of samples.
        samples: u64,
        /// The same seed gives the same values.
        seed: u64,
    },
}

/// A combination of values, one for each field.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// The number of the cell, from 0.
    pub number: u64,
    /// The values, in the order of the fields.
    pub levels: Vec<Level>,
}

impl Design {
    pub(crate) fn new(kind: Kind, samples: Option<u64>, seed: Option<u64>) -> Result<Self, Error> {
        if kind != Kind::Random && (samples.is_some() || seed.is_some()) {
            return Err(if samples.is_some() {
                Error::field("samples", "goes with design = \"random\"")
            } else {
                Error::field("seed", "goes with design = \"random\"; `seeds` sets the seeds of the runs")
            });
        }
        Ok(match kind {
            Kind::Grid => Self::Grid,
            Kind::List => Self::List,
            Kind::Random => {
                let missing =
                    || Error::field("samples", "is missing: how many random combinations there are");
                let samples = samples.ok_or_else(missing)?;
                if samples == 0 {
                    return Err(Error::field("samples", "must be at least 1, is 0"));
                }
                Self::Random { samples, seed: seed.unwrap_or(1) }
            }
        })
    }

    /// The number of combinations.
    ///
    /// # Errors
    /// If there are none, or too many to be counted, or the fields do not suit the design.
    pub fn cells(&self, fields: &[Field]) -> Result<u64, Error> {
        if fields.is_empty() {
            return Err(Error::field("fields", "is missing: give at least one [[fields]] that is varied"));
        }
        if let Self::Random { samples, .. } = self {
            return Ok(*samples);
        }
        let mut counts = Vec::new();
        for (i, field) in fields.iter().enumerate() {
            let range = || {
                let problem = "`from` and `to` are for design = \"random\" and for --find; give `values`";
                Error::field(format!("fields[{i}]"), problem)
            };
            counts.push(field.levels().ok_or_else(range)?.len() as u64);
        }
        match self {
            Self::List => match counts.iter().position(|&count| count != counts[0]) {
                None => Ok(counts[0]),
                Some(i) => Err(Error::field(
                    format!("fields[{i}]"),
                    format!(
                        "has {} values, but the first field has {}; a list combines them one by one",
                        counts[i], counts[0]
                    ),
                )),
            },
            Self::Grid | Self::Random { .. } => {
                let product = counts.iter().try_fold(1_u64, |product, &count| product.checked_mul(count));
                product.ok_or_else(|| Error::field("fields", "there are more than 2^64 combinations"))
            }
        }
    }

    /// The combination of this number.
    pub fn cell(&self, fields: &[Field], number: u64) -> Cell {
        let mut rest = number;
        let mut levels = Vec::with_capacity(fields.len());
        // Backwards, as the last field changes first.
        for (i, field) in fields.iter().enumerate().rev() {
            levels.push(match (&field.choice, self) {
                (Choice::Levels(all), Self::Grid) => {
                    let place = rest % all.len() as u64;
                    rest /= all.len() as u64;
                    all[place as usize].clone()
                }
                (Choice::Levels(all), Self::List) => all[number as usize % all.len()].clone(),
                (Choice::Levels(all), Self::Random { seed, .. }) => {
                    let place = (chance(*seed, i, number) * all.len() as f64) as usize;
                    all[place.min(all.len() - 1)].clone()
                }
                (Choice::Range(range), Self::Random { seed, .. }) => {
                    range.level(range.at(chance(*seed, i, number)))
                }
                (Choice::Range(range), Self::Grid | Self::List) => range.level(range.from),
            });
        }
        levels.reverse();
        Cell { number, levels }
    }
}

/// In [0, 1), for a field of a sample.
fn chance(seed: u64, field: usize, sample: u64) -> f64 {
    Stream::new(seed, &format!("design/{field}/{sample}")).uniform()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factor::Range;

    fn numbers(label: &str, numbers: &[f64]) -> Field {
        let range = Range { target: label.to_owned(), from: 0.0, to: 1.0, log: false, whole: false };
        let levels = numbers.iter().map(|&number| range.level(number)).collect();
        Field { label: label.to_owned(), unit: String::new(), choice: Choice::Levels(levels) }
    }

    fn names(cell: &Cell) -> Vec<&str> {
        cell.levels.iter().map(|level| level.name.as_str()).collect()
    }

    #[test]
    fn a_grid_has_every_combination_once_and_the_last_field_changes_first() {
        let fields = [numbers("a", &[1.0, 2.0]), numbers("b", &[3.0, 4.0, 5.0])];
        assert_eq!(Design::Grid.cells(&fields).unwrap(), 6);
        let cells: Vec<_> = (0..6).map(|i| Design::Grid.cell(&fields, i)).collect();
        let all: Vec<_> = cells.iter().map(names).collect();
        assert_eq!(all, [["1", "3"], ["1", "4"], ["1", "5"], ["2", "3"], ["2", "4"], ["2", "5"]]);
    }

    #[test]
    fn a_list_goes_through_its_fields_together() {
        let fields = [numbers("a", &[1.0, 2.0]), numbers("b", &[3.0, 4.0])];
        assert_eq!(Design::List.cells(&fields).unwrap(), 2);
        assert_eq!(names(&Design::List.cell(&fields, 1)), ["2", "4"]);
        let uneven = [numbers("a", &[1.0]), numbers("b", &[3.0, 4.0])];
        let error = Design::List.cells(&uneven).unwrap_err().to_string();
        assert!(error.starts_with("fields[1]: has 2 values, but the first field has 1"), "{error}");
    }

    #[test]
    fn random_samples_are_the_same_for_the_same_seed_and_fill_the_range() {
        let range = Range { target: "a".into(), from: 1.0, to: 1000.0, log: true, whole: true };
        let field = Field { label: "a".into(), unit: String::new(), choice: Choice::Range(range) };
        let design = Design::Random { samples: 400, seed: 3 };
        let fields = [field];
        let value = |i| design.cell(&fields, i).levels[0].number.unwrap();
        let values: Vec<_> = (0..400).map(value).collect();
        assert_eq!(values, (0..400).map(value).collect::<Vec<_>>());
        assert!(values.iter().all(|v| (1.0..=1000.0).contains(v) && v.fract() == 0.0));
        let low = values.iter().filter(|&&v| v < 31.6).count();
        assert!((150..250).contains(&low), "half of them are below the geometric middle: {low}");
        let other = Design::Random { samples: 400, seed: 4 };
        assert_ne!(value(0), other.cell(&fields, 0).levels[0].number.unwrap());
    }

    #[test]
    fn a_design_beyond_counting_is_refused_and_a_huge_one_is_not_listed() {
        let many: Vec<f64> = (0..2000).map(f64::from).collect();
        let field = || numbers("a", &many);
        let huge = [field(), field(), field()];
        assert_eq!(Design::Grid.cells(&huge).unwrap(), 8_000_000_000);
        assert_eq!(names(&Design::Grid.cell(&huge, 7_999_999_999)), ["1999", "1999", "1999"]);
        let beyond: Vec<_> = (0..7).map(|_| field()).collect();
        assert!(Design::Grid.cells(&beyond).unwrap_err().to_string().contains("more than 2^64"));
        assert!(Design::Grid.cells(&[]).unwrap_err().to_string().contains("[[fields]]"));
    }
}

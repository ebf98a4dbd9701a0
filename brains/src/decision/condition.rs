//! Conditions such as `front > 0.5`, for the methods of decision that have no utilities.

use thiserror::Error;

/// A state variable that is compared with a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// The variable's place.
    variable: usize,
    comparison: Comparison,
    number: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Comparison {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// A reason why a text is no condition.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ConditionError {
    /// The text is not a name, a comparison and a number.
    #[error("`{text}` is not a condition such as `{known} > 0.5`")]
    Form {
        /// The text given.
        text: String,
        /// A state variable that there is.
        known: String,
    },
    /// There is no such state variable.
    #[error("there is no state variable `{name}`; there are: {}", known.join(", "))]
    Variable {
        /// The name given.
        name: String,
        /// The variables that exist.
        known: Vec<String>,
    },
    /// The text has no comparison.
    #[error("`{found}` is not a comparison; there are: <, <=, >, >=")]
    Comparison {
        /// The text in that place.
        found: String,
    },
    /// The right side of the comparison is not a number.
    #[error("`{found}` is not a number")]
    Number {
        /// The text in that place.
        found: String,
    },
}

impl Condition {
    /// The condition of a text: `VARIABLE < NUMBER`, or with `<=`, `>` or `>=`. `variables` are their names, in order.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str, variables: &[&str]) -> Result<Self, ConditionError> {
        let parts: Vec<_> = text.split_whitespace().collect();
        let &[name, comparison, number] = parts.as_slice() else {
            let known = (*variables.first().unwrap_or(&"z")).to_owned();
            return Err(ConditionError::Form { text: text.to_owned(), known });
        };
        let Some(variable) = variables.iter().position(|variable| *variable == name) else {
            let known = variables.iter().map(|&variable| variable.to_owned()).collect();
            return Err(ConditionError::Variable { name: name.to_owned(), known });
        };
        let comparison = match comparison {
            "<" => Comparison::Less,
            "<=" => Comparison::LessOrEqual,
            ">" => Comparison::Greater,
            ">=" => Comparison::GreaterOrEqual,
            other => return Err(ConditionError::Comparison { found: other.to_owned() }),
        };
        let is_number = number.parse().ok().filter(|number: &f64| number.is_finite());
        let number = is_number.ok_or_else(|| ConditionError::Number { found: number.to_owned() })?;
        Ok(Self { variable, comparison, number })
    }

    /// The variable's place, the comparison as it is written, and the number.
    pub(crate) fn parts(&self) -> (usize, &'static str, f64) {
        let comparison = match self.comparison {
            Comparison::Less => "<",
            Comparison::LessOrEqual => "<=",
            Comparison::Greater => ">",
            Comparison::GreaterOrEqual => ">=",
        };
        (self.variable, comparison, self.number)
    }

    /// Whether the condition holds for these state variables.
    pub fn holds(&self, state: &[f64]) -> bool {
        let Some(value) = state.get(self.variable) else { return false };
        match self.comparison {
            Comparison::Less => *value < self.number,
            Comparison::LessOrEqual => *value <= self.number,
            Comparison::Greater => *value > self.number,
            Comparison::GreaterOrEqual => *value >= self.number,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_hold_or_do_not() {
        let holds = |text| Condition::parse(text, &["a", "b"]).unwrap().holds(&[1.0, -2.0]);
        assert!(holds("a > 0.5") && holds("a >= 1") && holds("b < -1.9") && holds("b <= -2"));
        assert!(!holds("a > 1") && !holds("b < -2") && !holds("a <= 0.99"));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let problem = |text| Condition::parse(text, &["a", "b"]).unwrap_err().to_string();
        assert_eq!(problem("a"), "`a` is not a condition such as `a > 0.5`");
        assert_eq!(problem("c > 1"), "there is no state variable `c`; there are: a, b");
        assert_eq!(problem("a = 1"), "`=` is not a comparison; there are: <, <=, >, >=");
        assert_eq!(problem("a > NaN"), "`NaN` is not a number");
    }
}

//! What is wrong with the text of a formula.

use std::fmt::{self, Display};

use baudbot_fields::printable::Printable;
use thiserror::Error;

/// The longest text of a formula.
pub const MOST_BYTES: usize = 4096;

/// The most parentheses, functions, signs and `not` that stand in one another.
pub const MOST_DEPTH: usize = 32;

/// A text that is no formula. Columns are characters, from 1; `E` is the error of who knows the quantities.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FormulaError<E> {
    /// The text is longer than [`MOST_BYTES`].
    #[error("the formula has {bytes} bytes; write at most {MOST_BYTES}, or several requirements")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// Something stands deeper than [`MOST_DEPTH`].
    #[error(
        "column {column}: this stands in more than {MOST_DEPTH} parentheses, functions, signs and `not`; leave some out"
    )]
    TooDeep {
        /// Where the depth is exceeded.
        column: usize,
    },
    /// Something else had to come.
    #[error("column {column}: found {found}, expected {expected}{}", Remark(.hint))]
    Unexpected {
        /// Where it stands.
        column: usize,
        /// What stands there.
        found: Token,
        /// What may stand there.
        expected: Expectation,
        /// What may have been meant.
        hint: Option<Hint>,
    },
    /// A number cannot be read, or is too large for one.
    #[error("column {column}: `{text}` is no finite number; write one such as 0.05 or 2e-3, without a unit")]
    Number {
        /// Where it begins.
        column: usize,
        /// What stands there.
        text: Box<str>,
    },
    /// Two comparisons share an operand.
    #[error("column {column}: a second comparison in a row; in place of `a < b < c` write `a < b and b < c`")]
    Chain {
        /// Where the second one is.
        column: usize,
    },
    /// A condition stands where a number must.
    #[error("column {column}: a condition stands where a number must; join conditions with `and` and `or`")]
    Condition {
        /// Where it begins.
        column: usize,
    },
    /// There is no such quantity.
    #[error("column {column}: {source}")]
    Quantity {
        /// Where its name begins.
        column: usize,
        /// The reason of who knows the quantities.
        source: E,
    },
}

/// The beginning of what stands at a place of a text: a word or a sign, or nothing at its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Token(pub(crate) Option<Box<str>>);

impl Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Some(text) => write!(f, "`{}`", Printable(text)),
            None => f.write_str("the end"),
        }
    }
}

/// What may stand at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expectation {
    /// A number, a quantity, a function or a parenthesis.
    Operand,
    /// A comparison of what stands before.
    Comparison,
    /// The end, or a word that joins another condition.
    End,
    /// The end of a parenthesis, or an operator.
    Closing,
    /// The comma between the two operands of a function, or an operator.
    Comma,
    /// The parenthesis behind the name of a function.
    Opening,
    /// The argument of a quantity.
    Argument,
    /// The end of the argument of a quantity.
    ArgumentEnd,
}

impl Display for Expectation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Operand => "a number or a quantity such as `clearance_m`",
            Self::Comparison => "`<`, `<=`, `>` or `>=`, as a condition compares numbers",
            Self::End => "`and`, `or` or the end",
            Self::Closing => "an operator or `)`",
            Self::Comma => "an operator or a comma, as min and max take two numbers",
            Self::Opening => "`(`, as abs, min and max are functions",
            Self::Argument => "a word of letters, digits, `_`, `-` and `.`",
            Self::ArgumentEnd => "`)`, as a quantity has one argument, which is a word",
        })
    }
}

/// What may have been meant by what is no part of the grammar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hint {
    /// Equality.
    Equal,
    /// The opposite.
    Unequal,
    /// `and`.
    And,
    /// `or`.
    Or,
    /// `not`.
    Not,
    /// `<=`.
    AtMost,
    /// `>=`.
    AtLeast,
    /// Division.
    Division,
}

impl Hint {
    /// The hint for this sign or word, if there is one.
    pub(crate) fn of(token: &str) -> Option<Self> {
        let hints: [(&[&str], Self); 8] = [
            (&["=", "==", "==="], Self::Equal),
            (&["!=", "!==", "<>", "≠"], Self::Unequal),
            (&["&", "&&", "∧", "AND", "And"], Self::And),
            (&["|", "||", "∨", "OR", "Or"], Self::Or),
            (&["!", "~", "¬", "NOT", "Not"], Self::Not),
            (&["=<", "≤"], Self::AtMost),
            (&["=>", "≥"], Self::AtLeast),
            (&["/"], Self::Division),
        ];
        hints.into_iter().find(|(tokens, _)| tokens.contains(&token)).map(|(_, hint)| hint)
    }
}

impl Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Equal => {
                "the robustness of equality is never above 0: write a band, as in `abs(a - b) < 0.1`"
            }
            Self::Unequal => "write what it must keep away from, as in `abs(a - b) > 0.1`",
            Self::And => "write `and`",
            Self::Or => "write `or`",
            Self::Not => "write `not`",
            Self::AtMost => "write `<=`",
            Self::AtLeast => "write `>=`, or `not a or b` if the one implies the other",
            Self::Division => "there is no division: multiply, as in `0.5 * a`, or multiply the other side",
        })
    }
}

/// A hint behind the rest of a message.
struct Remark<'a>(&'a Option<Hint>);

impl Display for Remark<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.as_ref().map_or(Ok(()), |hint| write!(f, "; {hint}"))
    }
}

//! Texts to formulas, by recursive descent.
//!
//! ```text
//! or         = and { "or" and }
//! and        = not { "and" not }
//! not        = "not" not | comparison
//! comparison = sum [ ( "<" | "<=" | ">" | ">=" ) sum ]
//! sum        = product { ( "+" | "-" ) product }
//! product    = sign { "*" sign }
//! sign       = "-" sign | primary
//! primary    = number | name [ "(" argument ")" ] | "abs" "(" or ")" | ( "min" | "max" ) "(" or "," or ")" | "(" or ")"
//! ```
//!
//! A parenthesis may begin a condition or a number, and only its inside tells which. So one descent reads both, and who needs
//! one of them refuses the other.

use crate::error::{Expectation, FormulaError, Hint, MOST_BYTES, MOST_DEPTH, Token};
use crate::expression::Expression;
use crate::formula::{Condition, Formula, Relation};

impl<Q> Formula<Q> {
    /// Reads a formula. `resolve` knows the quantities by their name and the argument in parentheses behind it.
    ///
    /// ```
    /// # use baudbot_require::Formula;
    /// let known = |name: &str, _: Option<&str>| match name {
    ///     "clearance_m" => Ok(0),
    ///     "speed_m_s" => Ok(1),
    ///     _ => Err("there is no such quantity"),
    /// };
    /// let formula = Formula::parse("clearance_m > 0.05 or abs(speed_m_s)<0.1", known).unwrap();
    /// assert_eq!(formula.to_string(), "clearance_m > 0.05 or abs(speed_m_s) < 0.1");
    /// assert_eq!(formula.robustness(|&i: &usize| [0.25, -0.5][i]), 0.2);
    /// let error = Formula::parse("clearance_m", known).unwrap_err();
    /// assert_eq!(error.to_string(), "column 12: found the end, expected `<`, `<=`, `>` or `>=`, as a condition compares numbers");
    /// ```
    ///
    /// # Errors
    /// Names the column, what stands there, and what may stand there; the error of `resolve` follows the column of the quantity.
    pub fn parse<E>(
        text: &str,
        resolve: impl FnMut(&str, Option<&str>) -> Result<Q, E>,
    ) -> Result<Self, FormulaError<E>> {
        if text.len() > MOST_BYTES {
            return Err(FormulaError::TooLong { bytes: text.len() });
        }
        let mut parser = Parser { text, rest: text.trim_start(), depth: 0, resolve };
        let part = parser.any()?;
        let condition = parser.condition(part)?;
        if !parser.rest.is_empty() {
            return Err(parser.unexpected(Expectation::End));
        }
        Ok(Self(condition))
    }
}

/// What a parenthesis may have in it.
enum Part<Q> {
    Condition(Condition<Q>),
    Expression(Expression<Q>),
}

struct Parser<'a, R> {
    text: &'a str,
    /// What is not read yet; it begins with no blank.
    rest: &'a str,
    depth: usize,
    resolve: R,
}

/// The reader of a rule of the grammar.
type Rule<P, Q, E> = fn(&mut P) -> Reading<Part<Q>, E>;

type Reading<T, E> = Result<T, FormulaError<E>>;

impl<'a, Q, E, R: FnMut(&str, Option<&str>) -> Result<Q, E>> Parser<'a, R> {
    fn any(&mut self) -> Reading<Part<Q>, E> {
        self.joined("or", Self::conjunction, Condition::Or)
    }

    fn conjunction(&mut self) -> Reading<Part<Q>, E> {
        self.joined("and", Self::negation, Condition::And)
    }

    fn joined(
        &mut self,
        word: &str,
        rule: Rule<Self, Q, E>,
        join: fn(Vec<Condition<Q>>) -> Condition<Q>,
    ) -> Reading<Part<Q>, E> {
        let first = rule(self)?;
        if self.word() != word {
            return Ok(first);
        }
        let mut all = vec![self.condition(first)?];
        while self.word() == word {
            self.advance(word.len());
            let next = rule(self)?;
            all.push(self.condition(next)?);
        }
        Ok(Part::Condition(join(all)))
    }

    fn negation(&mut self) -> Reading<Part<Q>, E> {
        if self.word() != "not" {
            return self.comparison();
        }
        self.advance("not".len());
        let inner = self.deeper(Self::negation)?;
        Ok(Part::Condition(Condition::Not(Box::new(self.condition(inner)?))))
    }

    fn comparison(&mut self) -> Reading<Part<Q>, E> {
        let at = self.at();
        let left = self.sum()?;
        let Some(relation) = self.relation() else { return Ok(left) };
        let left = self.expression(left, at)?;
        self.advance(self.sign().len());
        let right = self.operand(Self::sum)?;
        if self.relation().is_some() {
            return Err(FormulaError::Chain { column: self.column(self.at()) });
        }
        Ok(Part::Condition(Condition::Comparison { left, relation, right }))
    }

    fn sum(&mut self) -> Reading<Part<Q>, E> {
        let at = self.at();
        let first = self.product()?;
        if !self.rest.starts_with(['+', '-']) {
            return Ok(first);
        }
        let mut summands = vec![self.expression(first, at)?];
        loop {
            if self.takes('+') {
                summands.push(self.operand(Self::product)?);
            } else if self.takes('-') {
                summands.push(Expression::Negative(Box::new(self.operand(Self::product)?)));
            } else {
                return Ok(Part::Expression(Expression::Sum(summands)));
            }
        }
    }

    fn product(&mut self) -> Reading<Part<Q>, E> {
        let at = self.at();
        let first = self.signed()?;
        if !self.rest.starts_with('*') {
            return Ok(first);
        }
        let mut factors = vec![self.expression(first, at)?];
        while self.takes('*') {
            factors.push(self.operand(Self::signed)?);
        }
        Ok(Part::Expression(Expression::Product(factors)))
    }

    fn signed(&mut self) -> Reading<Part<Q>, E> {
        if !self.takes('-') {
            return self.primary();
        }
        let positive = self.deeper(|parser| parser.operand(Self::signed))?;
        Ok(Part::Expression(if let Expression::Number(number) = positive {
            Expression::Number(-number)
        } else {
            Expression::Negative(Box::new(positive))
        }))
    }

    fn primary(&mut self) -> Reading<Part<Q>, E> {
        if self.takes('(') {
            let inside = self.deeper(Self::any)?;
            self.expect(')', Expectation::Closing)?;
            return Ok(inside);
        }
        let expression = match self.word() {
            "" | "and" | "or" | "not" => return Err(self.unexpected(Expectation::Operand)),
            "abs" => {
                let [inner] = self.function()?;
                Expression::Absolute(Box::new(inner))
            }
            "min" => Expression::Least(Box::new(self.function()?)),
            "max" => Expression::Greatest(Box::new(self.function()?)),
            word if word.starts_with(|c: char| c.is_ascii_digit() || c == '.') => self.number()?,
            word => self.quantity(word)?,
        };
        Ok(Part::Expression(expression))
    }

    /// The operands of the function whose name comes next.
    fn function<const N: usize>(&mut self) -> Reading<[Expression<Q>; N], E> {
        self.advance(self.word().len());
        self.expect('(', Expectation::Opening)?;
        let mut operands = Vec::new();
        while operands.len() < N {
            if !operands.is_empty() {
                self.expect(',', Expectation::Comma)?;
            }
            operands.push(self.deeper(|parser| parser.operand(Self::any))?);
        }
        self.expect(')', Expectation::Closing)?;
        Ok(operands.try_into().ok().expect("the loop has read so many"))
    }

    fn number(&mut self) -> Reading<Expression<Q>, E> {
        let mut length = self.word().len();
        // The sign of an exponent is a part of the number.
        if self.word().ends_with(['e', 'E']) && self.rest[length..].starts_with(['+', '-']) {
            length += 1 + first_word(&self.rest[length + 1..]).len();
        }
        let text = &self.rest[..length];
        let Some(number) = text.parse().ok().filter(|number: &f64| number.is_finite()) else {
            return Err(FormulaError::Number { column: self.column(self.at()), text: brief(text) });
        };
        self.advance(length);
        Ok(Expression::Number(number))
    }

    fn quantity(&mut self, name: &'a str) -> Reading<Expression<Q>, E> {
        let at = self.at();
        self.advance(name.len());
        let mut argument = None;
        if self.takes('(') {
            let word = self.rest.split(|c| !is_of_word(c) && c != '-').next().unwrap_or_default();
            if word.is_empty() {
                return Err(self.unexpected(Expectation::Argument));
            }
            self.advance(word.len());
            self.expect(')', Expectation::ArgumentEnd)?;
            argument = Some(word);
        }
        let quantity = (self.resolve)(name, argument);
        let quantity =
            quantity.map_err(|source| FormulaError::Quantity { column: self.column(at), source })?;
        Ok(Expression::Quantity { name: name.into(), argument: argument.map(Into::into), quantity })
    }

    fn operand(&mut self, rule: Rule<Self, Q, E>) -> Reading<Expression<Q>, E> {
        let at = self.at();
        let part = rule(self)?;
        self.expression(part, at)
    }

    /// The part that begins at a byte, if it is a number.
    fn expression(&self, part: Part<Q>, at: usize) -> Reading<Expression<Q>, E> {
        match part {
            Part::Expression(expression) => Ok(expression),
            Part::Condition(_) => Err(FormulaError::Condition { column: self.column(at) }),
        }
    }

    /// The part that has just been read, if it is a condition.
    fn condition(&self, part: Part<Q>) -> Reading<Condition<Q>, E> {
        match part {
            Part::Condition(condition) => Ok(condition),
            Part::Expression(_) => Err(self.unexpected(Expectation::Comparison)),
        }
    }

    fn deeper<T>(&mut self, read: impl FnOnce(&mut Self) -> Reading<T, E>) -> Reading<T, E> {
        if self.depth == MOST_DEPTH {
            return Err(FormulaError::TooDeep { column: self.column(self.at()) });
        }
        self.depth += 1;
        let result = read(self);
        self.depth -= 1;
        result
    }

    fn expect(&mut self, sign: char, expected: Expectation) -> Reading<(), E> {
        if self.takes(sign) { Ok(()) } else { Err(self.unexpected(expected)) }
    }

    fn unexpected(&self, expected: Expectation) -> FormulaError<E> {
        let token = Some(self.word()).filter(|word| !word.is_empty()).unwrap_or_else(|| self.sign());
        let found = Token((!token.is_empty()).then(|| brief(token)));
        FormulaError::Unexpected { column: self.column(self.at()), found, expected, hint: Hint::of(token) }
    }
}

/// The text, in tokens.
impl<'a, R> Parser<'a, R> {
    /// The byte at which the rest begins.
    fn at(&self) -> usize {
        self.text.len() - self.rest.len()
    }

    fn column(&self, at: usize) -> usize {
        self.text[..at].chars().count() + 1
    }

    fn advance(&mut self, bytes: usize) {
        self.rest = self.rest[bytes..].trim_start();
    }

    fn takes(&mut self, sign: char) -> bool {
        let is_next = self.rest.starts_with(sign);
        if is_next {
            self.advance(sign.len_utf8());
        }
        is_next
    }

    /// The name, word or number that comes next; empty if it is none of them.
    fn word(&self) -> &'a str {
        first_word(self.rest)
    }

    /// The relation, or another run of the characters of which relations and the operators of other languages are made, that
    /// comes next; else one character.
    fn sign(&self) -> &'a str {
        let first = self.rest.chars().next().map_or(0, char::len_utf8);
        let run = self.rest.find(|c| !"<>=!&|".contains(c)).unwrap_or(self.rest.len());
        &self.rest[..run.max(first)]
    }

    fn relation(&self) -> Option<Relation> {
        match self.sign() {
            "<" => Some(Relation::Less),
            "<=" => Some(Relation::AtMost),
            ">" => Some(Relation::Greater),
            ">=" => Some(Relation::AtLeast),
            _ => None,
        }
    }
}

fn first_word(text: &str) -> &str {
    text.split(|c| !is_of_word(c)).next().unwrap_or_default()
}

fn is_of_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_' || c == '.'
}

/// The beginning, as messages quote it.
fn brief(text: &str) -> Box<str> {
    text.chars().take(40).collect()
}

#[cfg(test)]
mod tests;

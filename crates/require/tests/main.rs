//! Formulas and requirements against their definitions, which are evaluated here over whole traces.

use baudbot_require::{Formula, Monitor, Requirement, Rule, Verdict};
use proptest::prelude::*;

/// A formula as it is defined: binary, with its text in too many parentheses or too few.
#[derive(Clone, Debug)]
enum Model {
    Number(f64),
    Quantity(usize),
    Negative(Box<Self>),
    Absolute(Box<Self>),
    Two(&'static str, Box<[Self; 2]>),
    Not(Box<Self>),
}

impl Model {
    fn text(&self) -> String {
        match self {
            Self::Number(number) => format!("{number:?}"),
            Self::Quantity(i) => NAMES[*i].to_owned(),
            Self::Negative(inner) => format!("-({})", inner.text()),
            Self::Absolute(inner) => format!("abs ({})", inner.text()),
            Self::Two(name @ ("min" | "max"), both) => {
                format!("{name}({},{})", both[0].text(), both[1].text())
            }
            // To the left nothing that is bound as tightly needs parentheses.
            Self::Two(operator @ ("+" | "*"), both) if matches!(both[0], Self::Two("*", _)) => {
                format!("{} {operator}({})", both[0].text(), both[1].text())
            }
            Self::Two(operator @ ("+" | "*"), both) => {
                format!("({}){operator} {}", both[0].text(), both[1].closed())
            }
            Self::Two(operator, both) => format!("({}) {operator} ({})", both[0].text(), both[1].text()),
            Self::Not(inner) => format!("not({})", inner.text()),
        }
    }

    fn closed(&self) -> String {
        if matches!(self, Self::Two("min" | "max", _) | Self::Quantity(_) | Self::Absolute(_)) {
            self.text()
        } else {
            format!("({})", self.text())
        }
    }

    /// The number of an expression, or the robustness of a condition.
    fn value(&self, sample: &Sample) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Quantity(i) => sample.values[*i],
            Self::Negative(inner) | Self::Not(inner) => -inner.value(sample),
            Self::Absolute(inner) => inner.value(sample).abs(),
            Self::Two(operator, both) => {
                let [a, b] = [both[0].value(sample), both[1].value(sample)];
                let atom = |difference: f64| if difference.is_nan() { f64::NEG_INFINITY } else { difference };
                match *operator {
                    "+" => a + b,
                    "-" => a - b,
                    "*" => a * b,
                    "min" | "max" if a.is_nan() || b.is_nan() => f64::NAN,
                    "min" | "and" => a.min(b),
                    "max" | "or" => a.max(b),
                    ">" | ">=" => atom(a - b),
                    _ => atom(b - a),
                }
            }
        }
    }

    /// Whether a condition holds, by truth alone. What is no number fails in each comparison.
    fn holds(&self, sample: &Sample) -> bool {
        match self {
            Self::Not(inner) => !inner.holds(sample),
            Self::Two("and", both) => both[0].holds(sample) && both[1].holds(sample),
            Self::Two("or", both) => both[0].holds(sample) || both[1].holds(sample),
            Self::Two(relation, both) => {
                let [a, b] = [both[0].value(sample), both[1].value(sample)];
                let is_number = !(a - b).is_nan();
                is_number
                    && match *relation {
                        "<" => a < b,
                        "<=" => a <= b,
                        ">" => a > b,
                        _ => a >= b,
                    }
            }
            Self::Number(_) | Self::Quantity(_) | Self::Negative(_) | Self::Absolute(_) => {
                panic!("{self:?} is a number")
            }
        }
    }

    fn formula(&self) -> Formula<usize> {
        parse(&self.text())
    }
}

const NAMES: [&str; 3] = ["x_m", "age_ms(ir-front)", "speed_m_s"];

fn parse(text: &str) -> Formula<usize> {
    let known = |name: &str, argument: Option<&str>| {
        let whole = argument.map_or_else(|| name.to_owned(), |argument| format!("{name}({argument})"));
        NAMES.iter().position(|known| *known == whole).ok_or(whole)
    };
    Formula::parse(text, known).unwrap_or_else(|error| panic!("{text}: {error}"))
}

#[derive(Clone, Debug)]
struct Sample {
    time_ns: u64,
    values: [f64; 3],
}

fn two<S: Strategy<Value = Model> + Clone + 'static>(
    operators: &'static [&'static str],
    part: S,
) -> impl Strategy<Value = Model> {
    (prop::sample::select(operators), [part.clone(), part])
        .prop_map(|(operator, both)| Model::Two(operator, Box::new(both)))
}

fn any_number() -> impl Strategy<Value = f64> {
    // Whole numbers meet bounds.
    prop_oneof![
        8 => (-3..=3).prop_map(f64::from),
        4 => -10.0..10.0,
        1 => prop::num::f64::NORMAL,
    ]
}

fn any_model() -> impl Strategy<Value = Model> {
    let leaf = prop_oneof![any_number().prop_map(Model::Number), (0..3_usize).prop_map(Model::Quantity)];
    let expression = leaf.prop_recursive(3, 12, 2, |inner| {
        prop_oneof![
            4 => two(&["+", "-", "*", "min", "max"], inner.clone()),
            1 => inner.clone().prop_map(|inner| Model::Negative(Box::new(inner))),
            1 => inner.prop_map(|inner| Model::Absolute(Box::new(inner))),
        ]
    });
    two(&["<", "<=", ">", ">="], expression.boxed()).prop_recursive(3, 12, 2, |inner| {
        prop_oneof![
            3 => two(&["and", "or"], inner.clone()),
            1 => inner.prop_map(|inner| Model::Not(Box::new(inner))),
        ]
    })
}

fn any_value() -> impl Strategy<Value = f64> {
    prop_oneof![
        20 => any_number(),
        2 => Just(f64::INFINITY),
        1 => Just(f64::NAN),
    ]
}

fn any_trace() -> impl Strategy<Value = Vec<Sample>> {
    prop::collection::vec((1..20_u64, [any_value(), any_value(), any_value()]), 0..40).prop_map(|steps| {
        let mut time_ns = 0;
        let sample = |(step_ns, values)| {
            time_ns += step_ns;
            Sample { time_ns: time_ns - 1, values }
        };
        steps.into_iter().map(sample).collect()
    })
}

/// The first of the best by these keys, where a greater key is better.
fn first_best(all: impl Iterator<Item = Verdict>, sign: f64) -> Option<Verdict> {
    let key = |verdict: &Verdict| (sign * verdict.robustness, verdict.holds == (sign > 0.0));
    all.reduce(|first, next| if key(&next) > key(&first) { next } else { first })
}

/// The verdict by its definition.
fn defined(kind: usize, [a, b]: &[Model; 2], from_ns: u64, within_ns: u64, trace: &[Sample]) -> Verdict {
    let counted: Vec<_> = trace.iter().filter(|sample| sample.time_ns >= from_ns).collect();
    let of = |model: &Model, sample: &Sample| Verdict {
        robustness: model.value(sample),
        holds: model.holds(sample),
        at_ns: sample.time_ns,
    };
    let not =
        |verdict: Verdict| Verdict { robustness: -verdict.robustness, holds: !verdict.holds, ..verdict };
    let until = |end_ns: u64| move |sample: &&&Sample| sample.time_ns <= end_ns;
    let all = counted.iter();
    let found = match kind {
        0 => first_best(all.map(|sample| of(a, sample)), -1.0),
        1 => first_best(all.map(|sample| not(of(a, sample))), -1.0),
        2 => first_best(all.map(|sample| of(a, sample)), 1.0),
        3 => first_best(all.filter(until(from_ns + within_ns)).map(|sample| of(a, sample)), 1.0),
        _ => {
            let implication = |(i, trigger): (usize, &&Sample)| {
                let soon = counted[i..].iter().filter(until(trigger.time_ns + within_ns));
                let reaction = soon.map(|sample| of(b, sample));
                let both = [not(of(a, trigger))].into_iter().chain(reaction);
                Verdict { at_ns: trigger.time_ns, ..first_best(both, 1.0).unwrap() }
            };
            first_best(all.enumerate().map(implication), -1.0)
        }
    };
    let holds = !matches!(kind, 2 | 3);
    let robustness = if holds { f64::INFINITY } else { f64::NEG_INFINITY };
    found.unwrap_or(Verdict { robustness, holds, at_ns: from_ns })
}

fn rule(kind: usize, [a, b]: &[Model; 2], within_ns: u64) -> Rule<usize> {
    match kind {
        0 => Rule::Always(a.formula()),
        1 => Rule::Never(a.formula()),
        2 => Rule::Eventually { formula: a.formula(), within_ns: None },
        3 => Rule::Eventually { formula: a.formula(), within_ns: Some(within_ns) },
        _ => Rule::Whenever { formula: a.formula(), then: b.formula(), within_ns },
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn a_normal_form_is_the_same_formula(model in any_model()) {
        let formula = model.formula();
        let text = formula.to_string();
        prop_assert_eq!(parse(&text), formula, "{}", text);
    }

    #[test]
    fn verdicts_are_those_of_the_definition_after_each_sample(
        kind in 0..5_usize,
        models in [any_model(), any_model()],
        from_ns in 0..60_u64,
        within_ns in 0..80_u64,
        trace in any_trace(),
    ) {
        let mut monitor = Monitor::new(Requirement { rule: rule(kind, &models, within_ns), from_ns });
        for count in 0..=trace.len() {
            if let Some(sample) = count.checked_sub(1).map(|i| &trace[i]) {
                monitor.see(sample.time_ns, |&quantity| sample.values[quantity]).unwrap();
            }
            let expected = defined(kind, &models, from_ns, within_ns, &trace[..count]);
            prop_assert_eq!(monitor.verdict(), expected, "{} after {} samples", monitor.requirement(), count);
        }
    }

    #[test]
    fn no_text_is_too_much(text in "[-a-c0-9.<>=()+*,& e_é\u{1b}]{0,60}|(a|and|not|or|<|\\(|\\)|1|-|\\*| ){0,40}") {
        if let Ok(formula) = Formula::parse(&text, |name, _| Ok::<_, ()>(name.to_owned())) {
            let normal = formula.to_string();
            prop_assert_eq!(Formula::parse(&normal, |name, _| Ok::<_, ()>(name.to_owned())), Ok(formula));
        }
    }
}

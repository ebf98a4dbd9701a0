use std::thread;

use super::*;

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no `{0}`")]
struct NoQuantity(String);

const NAMES: [&str; 6] = ["clearance_m", "age_ms(ir-front.2)", "speed_m_s", "a", "b", "c"];

fn parse(text: &str) -> Result<Formula<usize>, FormulaError<NoQuantity>> {
    Formula::parse(text, |name, argument| {
        let whole = argument.map_or_else(|| name.to_owned(), |argument| format!("{name}({argument})"));
        NAMES.iter().position(|known| *known == whole).ok_or(NoQuantity(whole))
    })
}

fn robustness(text: &str) -> f64 {
    let values = [0.25, f64::INFINITY, -0.5, 1.0, 2.0, f64::NAN];
    parse(text).unwrap().robustness(|&quantity| values[quantity])
}

#[test]
fn normal_forms_have_no_parentheses_but_what_they_need() {
    for (text, normal) in [
        ("clearance_m>0.05", "clearance_m > 0.05"),
        ("  age_ms ( ir-front.2 )>=2e2 ", "age_ms(ir-front.2) >= 200"),
        ("(a<1 and (b<2)) or not(c<3)", "a < 1 and b < 2 or not c < 3"),
        ("a<1 and(b<2 or c<3)", "a < 1 and (b < 2 or c < 3)"),
        ("not(a<1 and b<2)and not not c<3", "not (a < 1 and b < 2) and not not c < 3"),
        ("((a)+0.50*(b))<3", "a + 0.5 * b < 3"),
        ("(a+b)*-c<-(a*b)", "(a + b) * -c < -(a * b)"),
        ("a-(b-c)-2- -3<--1", "a - (b - c) - 2 - -3 < 1"),
        ("a + -2 <= a + -(a*b) - -b*c", "a + -2 <= a - a * b - -b * c"),
        ("min(a,max(b,-c))>abs((a-b)*2)", "min(a, max(b, -c)) > abs((a - b) * 2)"),
        ("a < 1E-9 or a > 1.5e+300", "a < 1e-9 or a > 1.5e300"),
        ("((a + b)) * (c) < .5", "(a + b) * c < 0.5"),
    ] {
        let formula = parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(formula.to_string(), normal, "{text}");
        assert_eq!(parse(normal).as_ref(), Ok(&formula), "{text}");
    }
}

#[test]
fn robustness_is_the_distance_from_the_bound() {
    for (text, expected) in [
        ("clearance_m > 0.05", 0.2),
        ("clearance_m <= 0.05", -0.2),
        ("a < b and clearance_m < 1", 0.75),
        ("a > b or clearance_m > 1", -0.75),
        ("not (a > b or clearance_m > 1)", 0.75),
        ("a + 0.5 * b < 3", 1.0),
        ("abs(speed_m_s) > 1", -0.5),
        ("min(a, b) * -max(a, b) > 0", -2.0),
        ("age_ms(ir-front.2) > 200", f64::INFINITY),
        ("age_ms(ir-front.2) <= 200", f64::NEG_INFINITY),
    ] {
        assert_eq!(robustness(text), expected, "{text}");
    }
}

#[test]
fn what_is_no_number_fails_in_either_direction() {
    let infinity = "age_ms(ir-front.2)";
    for text in [
        "c > 0".to_owned(),
        "c < 0".to_owned(),
        "min(c, a) < 5".to_owned(),
        "max(a, c) > 0".to_owned(),
        format!("{infinity} - {infinity} <= 0"),
        format!("{infinity} >= {infinity}"),
        format!("0 * {infinity} <= 1"),
    ] {
        assert_eq!(robustness(&text), f64::NEG_INFINITY, "{text}");
        assert_eq!(robustness(&format!("not ({text})")), f64::INFINITY, "{text}");
    }
}

#[test]
fn errors_say_the_column_and_what_to_write() {
    let operand = "expected a number or a quantity such as `clearance_m`";
    let comparison = "expected `<`, `<=`, `>` or `>=`, as a condition compares numbers";
    let end = "expected `and`, `or` or the end";
    for (text, message) in [
        ("", format!("column 1: found the end, {operand}")),
        ("clearance_m", format!("column 12: found the end, {comparison}")),
        ("a and b > 3", format!("column 3: found `and`, {comparison}")),
        ("a > 3 b", format!("column 7: found `b`, {end}")),
        ("a > 3)", format!("column 6: found `)`, {end}")),
        ("a > and", format!("column 5: found `and`, {operand}")),
        ("a > \u{1b}[m", format!("column 5: found `\\u{{1b}}`, {operand}")),
        ("(a > 3", "column 7: found the end, expected an operator or `)`".into()),
        (
            "a > 5m",
            "column 5: `5m` is no finite number; write one such as 0.05 or 2e-3, without a unit".into(),
        ),
        (
            "a > 1e999",
            "column 5: `1e999` is no finite number; write one such as 0.05 or 2e-3, without a unit".into(),
        ),
        (
            "1 < a < 2",
            "column 7: a second comparison in a row; in place of `a < b < c` write `a < b and b < c`".into(),
        ),
        (
            "(a < b) + 1 > 2",
            "column 1: a condition stands where a number must; join conditions with `and` and `or`".into(),
        ),
        (
            "a < (b < c)",
            "column 5: a condition stands where a number must; join conditions with `and` and `or`".into(),
        ),
        (
            "abs(a > 3) > 1",
            "column 5: a condition stands where a number must; join conditions with `and` and `or`".into(),
        ),
        ("é_m > 1", "column 1: there is no `é_m`".into()),
        ("a > 1 and age_ms(left) > 1", "column 11: there is no `age_ms(left)`".into()),
        ("age_ms() > 1", "column 8: found `)`, expected a word of letters, digits, `_`, `-` and `.`".into()),
        (
            "age_ms(a b) > 1",
            "column 10: found `b`, expected `)`, as a quantity has one argument, which is a word".into(),
        ),
        (
            "min(a) > 1",
            "column 6: found `)`, expected an operator or a comma, as min and max take two numbers".into(),
        ),
        ("abs > 1", "column 5: found `>`, expected `(`, as abs, min and max are functions".into()),
        (
            "a == 3",
            format!(
                "column 3: found `==`, {comparison}; the robustness of equality is never above 0: write a band, as in `abs(a - b) < 0.1`"
            ),
        ),
        (
            "a != 3",
            format!(
                "column 3: found `!=`, {comparison}; write what it must keep away from, as in `abs(a - b) > 0.1`"
            ),
        ),
        (
            "a => 3",
            format!(
                "column 3: found `=>`, {comparison}; write `>=`, or `not a or b` if the one implies the other"
            ),
        ),
        ("a ≤ 3", format!("column 3: found `≤`, {comparison}; write `<=`")),
        ("a > 3 && b > 1", format!("column 7: found `&&`, {end}; write `and`")),
        ("a > 3 OR b > 1", format!("column 7: found `OR`, {end}; write `or`")),
        ("!a > 3", format!("column 1: found `!`, {operand}; write `not`")),
        (
            "a / 2 > 3",
            format!(
                "column 3: found `/`, {comparison}; there is no division: multiply, as in `0.5 * a`, or multiply the other side"
            ),
        ),
    ] {
        assert_eq!(parse(text).unwrap_err().to_string(), message, "{text}");
    }
}

#[test]
fn depth_and_length_have_an_end_that_needs_little_stack() {
    let read = || {
        for (open, inside, close) in [
            ("(", "a > 1", ")"),
            ("not ", "a > 1", ""),
            ("1 < -", "a", ""),
            ("1 < abs(", "a", ")"),
            ("1 < min(1, ", "a", ")"),
            ("1 < (1 + ", "a", ")"),
        ] {
            let (start, open) = open.split_once("< ").map_or(("", open), |(_, open)| ("1 < ", open));
            let text = |depth| format!("{start}{}{inside}{}", open.repeat(depth), close.repeat(depth));
            parse(&text(MOST_DEPTH)).unwrap_or_else(|error| panic!("{open}: {error}"));
            let error = parse(&text(MOST_DEPTH + 1)).unwrap_err();
            assert!(matches!(error, FormulaError::TooDeep { .. }), "{open}: {error}");
            parse(&open.repeat(MOST_BYTES / open.len())).unwrap_err();
        }
        let long = "a + ".repeat(MOST_BYTES / 4 - 2) + "a > 1";
        assert_eq!(parse(&long).unwrap().to_string(), long);
    };
    thread::Builder::new().stack_size(256 << 10).spawn(read).unwrap().join().unwrap();
    let error = parse(&"(".repeat(MOST_DEPTH + 2)).unwrap_err();
    assert_eq!(error, FormulaError::TooDeep { column: MOST_DEPTH + 2 });
    assert_eq!(parse(&" ".repeat(MOST_BYTES + 1)), Err(FormulaError::TooLong { bytes: MOST_BYTES + 1 }));
}

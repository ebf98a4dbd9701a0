"""Tests of notes.py: the grammar of marks, what a mark says of its place, and what the check finds."""

import unittest

import notes

RUST = '''//! Motor: Wahde 2016, Eqs. (1.8)–(1.10).
//!
//! Deviations. (3.19) is only mentioned.
//!
//! τ = K (v_ref − v)       (3.15)
//! | table | (8.6) |

/// Fig. 1.13.
pub struct Motor {
    /// R of (1.6).
    ohm: f64,
}

impl Run for Motor {
    /// (1.1), then
    /// (1.2).
    #[inline]
    fn run(&self) {
        // (1.3) is only mentioned.
    }
}

#[cfg(test)]
mod tests {
    /// (1.4) of a helper.
    fn helper() {}

    /// (1.5).
    #[test]
    fn it_runs() {
        // (1.7) inside.
    }
}
'''


class Grammar(unittest.TestCase):
    def named(self, text):
        return list(notes.ids(text))

    def test_ranges_are_filled_in_and_lists_are_not(self):
        self.assertEqual(self.named("(1.8)–(1.10)"), ["(1.8)", "(1.9)", "(1.10)"])
        self.assertEqual(self.named("Eqs. (6.4) to (6.7)"), [f"(6.{n})" for n in (4, 5, 6, 7)])
        self.assertEqual(self.named("(2.2), (2.3) and (2.7)–(2.9)"), [f"(2.{n})" for n in (2, 3, 7, 8, 9)])
        self.assertEqual(self.named("(Eqs. 3.12 and 3.15)"), ["(3.12)", "(3.15)"])

    def test_figures_listings_and_sections(self):
        self.assertEqual(self.named("Figs. 6.8, 6.9 and 6.13–6.15; Figure 7.4"), [f"Fig. {n}" for n in ("6.8", "6.9", "6.13", "6.14", "6.15", "7.4")])
        self.assertEqual(self.named("listings 5.1 and 5.2, Listing 5.4's order"), ["Listing 5.1", "Listing 5.2", "Listing 5.4"])
        self.assertEqual(self.named("Wahde 2016, §7.2.1; Sections 5.2 and 8.1, section 6.3 of the notes"), ["§7.2.1", "§5.2", "§8.1", "§6.3"])

    def test_numbers_that_are_none_of_the_notes(self):
        self.assertEqual(self.named("(1.05), (1.5 m), 0.1 (9.2), f(1.5), [2](3.4), Fig. 3, Config. 1.2, 1.8–1.10, (1.123)"), [])

    def test_a_range_is_within_a_chapter(self):
        with self.assertRaises(SystemExit):
            self.named("(1.8)–(2.1)")


class Places(unittest.TestCase):
    def said(self, path, text):
        return {(mark.item, mark.says, mark.name) for mark in notes.marks(path, text)}

    def test_rust(self):
        expected = {("(1.8)", "code", ""), ("(1.9)", "code", ""), ("(1.10)", "code", ""), ("(3.15)", "code", ""), ("(3.19)", "mention", ""), ("(8.6)", "mention", "")}
        expected |= {("Fig. 1.13", "code", "Motor"), ("(1.6)", "mention", ""), ("(1.1)", "code", "Motor::run"), ("(1.2)", "code", "Motor::run"), ("(1.3)", "mention", "")}
        expected |= {("(1.4)", "test", ""), ("(1.5)", "test", "it_runs"), ("(1.7)", "test", "it_runs")}
        self.assertEqual(self.said("crates/sim/src/motor.rs", RUST), expected)
        self.assertEqual({says for _, says, _ in self.said("crates/sim/tests/motor.rs", RUST)}, {"test"})

    def test_scenarios_and_python(self):
        self.assertEqual(self.said("catalogue/scenarios/wedge.toml", "# Locking: Fig. 6.13\n# of the notes."), {("Fig. 6.13", "shown", "")})
        self.assertEqual(self.said("catalogue/exercises/taxis.toml", 'title = "Find it"\nsection = "4.4.2"\n'), {("§4.4.2", "shown", "")})
        self.assertEqual(self.said("catalogue/exercises/a.py", '"""By (2.5)\nto (2.6)."""\nf = (1.5)\n# (3.1)\n'), {("(2.5)", "shown", ""), ("(2.6)", "shown", ""), ("(3.1)", "shown", "")})


class Checks(unittest.TestCase):
    def setUp(self):
        self.text = (notes.ROOT / notes.LIST).read_text()

    def amiss(self, text, *marks):
        known = set(notes.Notes(self.text, []).amiss)
        return [error for error in notes.Notes(text, [notes.Mark(item, "", path, says) for item, says, path in marks]).amiss if error not in known]

    def test_gaps_twins_and_strangers(self):
        line = next(line for line in self.text.splitlines() if line.startswith('"Fig. 1.3"'))
        self.assertEqual(self.amiss(self.text.replace(line, "")), [f"{notes.LIST}: Fig. 1.3 of the notes is missing"])
        self.assertEqual(self.amiss(self.text.replace(line, line + "\n" + line.replace("Fig. 1.3", "§1.3"))), [f"{notes.LIST}: §1.3 is not in the notes"])
        self.assertIn(f"{notes.LIST}: Fig. 1.4 is there twice", self.amiss(self.text.replace(line, line.replace("Fig. 1.3", "Figs. 1.3 and 1.4"))))

    def test_marks_beside_the_list(self):
        self.assertIn("a.rs: (1.11) is not in", self.amiss(self.text, ("(1.11)", "code", "a.rs"))[0])
        self.assertIn("(2.30) has marks in code and in no test", self.amiss(self.text, ("(2.30)", "code", "a.rs"))[0])
        self.assertIn("take `planned` away", self.amiss(self.text.replace('"Fig. 1.3" = { what', '"Fig. 1.3" = { planned = true, what'), ("Fig. 1.3", "code", "a.rs"))[0])
        self.assertIn(f"{notes.LIST}: (2.30): (2.30) has no mark in code and no `reason`", notes.Notes(self.text, []).amiss)

    def test_the_list_and_the_code_agree(self):
        self.assertEqual(notes.read().amiss, [])


if __name__ == "__main__":
    unittest.main()

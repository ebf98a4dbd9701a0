//! A C file as it is written: the state of the brain, the start of it, and functions.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::ops::Range;

use super::fragment::Fragment;

/// A C file as it grows.
#[derive(Default)]
pub(super) struct Writer {
    /// The fields of `struct brain`.
    fields: String,
    /// The statements of `brain_init`.
    start: String,
    functions: String,
    depth: usize,
    fragments: BTreeSet<Fragment>,
}

impl Writer {
    /// A field of the brain's state, which is zero at the start.
    pub(super) fn field(&mut self, declaration: impl Display, meaning: impl Display) {
        self.fields += &format!("  {declaration}; /* {meaning} */\n");
    }

    /// Another value of a field at the start.
    pub(super) fn start(&mut self, field: impl Display, value: impl Display) {
        self.start += &format!("  brain->{field} = {value};\n");
    }

    /// A fixed part of the file, with those that it needs.
    pub(super) fn uses(&mut self, fragment: Fragment) {
        for needed in fragment.needs() {
            self.uses(*needed);
        }
        self.fragments.insert(fragment);
    }

    /// A line of a function, or of what stands before it.
    pub(super) fn line(&mut self, text: impl Display) {
        self.functions += &format!("{:1$}{text}\n", "", 2 * self.depth);
    }

    /// A block with this head.
    pub(super) fn block(&mut self, head: impl Display, body: impl FnOnce(&mut Self)) {
        self.line(format_args!("{head} {{"));
        self.depth += 1;
        body(self);
        self.depth -= 1;
        self.line("}");
    }

    /// A function that the file has for itself, with a comment before it.
    pub(super) fn function(
        &mut self,
        meaning: impl Display,
        signature: impl Display,
        body: impl FnOnce(&mut Self),
    ) {
        self.functions += "\n";
        self.line(format_args!("/* {meaning} */"));
        self.block(format_args!("static {signature}"), body);
    }

    /// A table of numbers, which an AVR keeps in its flash.
    pub(super) fn table<'a>(&mut self, name: impl Display, numbers: impl Iterator<Item = &'a f64>) {
        let numbers: Vec<_> = numbers.map(|number| c(*number).to_string()).collect();
        self.functions += "\n";
        self.line(format_args!("static const brain_real {name}[] BRAIN_FLASH = {{"));
        numbers.chunks(NUMBERS_A_LINE).for_each(|some| self.line(format_args!("  {},", some.join(", "))));
        self.line("};");
    }

    /// The body once for each place of a range: it gets the place as C has it.
    pub(super) fn each(&mut self, range: Range<usize>, body: impl FnOnce(&mut Self, &str)) {
        match range.len() {
            1 => body(self, &range.start.to_string()),
            _ => {
                let head = format!("for (i = {}; i < {}; i++)", range.start, range.end);
                self.block(head, |writer| body(writer, "i"));
            }
        }
    }

    /// The file, with these two functions at its end.
    pub(super) fn finish(self, head: &str, turn: &str) -> String {
        let fragments: Vec<_> = self.fragments.iter().map(|fragment| fragment.text()).collect();
        format!(
            "{head}\n{}\nstruct brain {{\n{}}};\n{}\nvoid brain_init(struct brain *brain) {{\n  memset(brain, 0, sizeof *brain);\n{}}}\n\n\
             void brain_turn(struct brain *brain, const struct brain_readings *readings, struct brain_command *command) {{\n{turn}}}\n",
            fragments.join("\n"),
            self.fields,
            self.functions,
            self.start,
        )
    }
}

/// A number as C reads it, to the same bits.
pub(super) fn c(number: f64) -> impl Display {
    format!("{number:?}")
}

/// A text as it may stand in a comment: printable, and without what ends one, continues a line, or is a trigraph.
pub(super) fn plain(text: &str) -> String {
    let is_plain = |letter: char| (letter.is_ascii_graphic() || letter == ' ') && !"*\\?".contains(letter);
    text.chars().map(|letter| if is_plain(letter) { letter } else { '_' }).collect()
}

const NUMBERS_A_LINE: usize = 6;

//! The figures and findings of each crate.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Display, Formatter};

use super::graph::{self, Graph};
use super::prose::Prose;
use super::sources::Sources;
use super::text::{Word, apart, bare, code_lines, group_end, inside, outside, parts, words};

/// The most lines that a function may have.
const LONGEST_FUNCTION: usize = 40;
/// The most lines that a file may have without its tests.
const LONGEST_FILE: usize = 400;

/// A crate, or the tests and benches beside all crates.
#[derive(Debug, Default)]
pub(super) struct Crate {
    /// Its folder.
    pub(super) name: String,
    pub(super) files: usize,
    /// Lines of code without those of tests.
    pub(super) code: usize,
    /// Lines of tests.
    pub(super) tests: usize,
    pub(super) modules: usize,
    /// Groups of modules that all reach each other.
    pub(super) circles: Vec<Vec<String>>,
    /// Arms that match anything.
    pub(super) wildcards: usize,
    /// The comments of all files, those of tests too.
    pub(super) prose: Prose,
    pub(super) findings: Vec<Finding>,
}

/// A place that breaks a rule.
#[derive(Debug)]
pub(super) struct Finding {
    /// A path below `src`, and behind a colon the function if it is one.
    pub(super) place: String,
    pub(super) fault: Fault,
}

/// The rule that a place breaks.
#[derive(Debug, Clone, Copy)]
pub(super) enum Fault {
    LongFunction { lines: usize },
    LongFile { lines: usize },
    StringError,
    ReadError,
    ParticipleType,
}

impl Fault {
    /// The table of its exceptions.
    pub(super) fn table(self) -> &'static str {
        match self {
            Self::LongFunction { .. } => "long_functions",
            Self::LongFile { .. } => "long_files",
            Self::StringError => "string_errors",
            Self::ReadError => "read_errors",
            Self::ParticipleType => "participles",
        }
    }
}

impl Display for Fault {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::LongFunction { lines } => write!(
                f,
                "the function has {lines} lines, more than {LONGEST_FUNCTION}; split it by what its parts mean"
            ),
            Self::LongFile { lines } => write!(
                f,
                "the file has {lines} lines without its tests, more than {LONGEST_FILE}; move its second idea into another"
            ),
            Self::StringError => {
                f.write_str("an error is a String; give it an error type that names the path")
            }
            Self::ReadError => {
                f.write_str("the words of an error are for people; give the error a kind, and match on that")
            }
            Self::ParticipleType => {
                f.write_str("a type is a thing, and its name a noun, such as `Detection` in place of `Found`")
            }
        }
    }
}

/// The crates by name, and what is beside them.
pub(super) fn crates(files: &Sources) -> Vec<Crate> {
    let mut inside: BTreeMap<&str, BTreeMap<&str, &str>> = BTreeMap::new();
    let mut beside = Crate { name: "tests and benches beside the crates".to_owned(), ..Crate::default() };
    for (path, text) in files.iter().filter(|(path, _)| !path.contains("/generated/")) {
        if let Some((name, path)) = path.split_once("/src/") {
            inside.entry(name).or_default().insert(path, text);
        } else {
            beside.files += 1;
            beside.tests += code_lines(&bare(text));
            beside.prose.add(text);
        }
    }
    inside.iter().map(|(name, files)| Crate::measured(name, files)).chain([beside]).collect()
}

impl Crate {
    /// A crate with these files, by their paths below `src`.
    fn measured(name: &str, files: &BTreeMap<&str, &str>) -> Self {
        let mut measured = Self { name: name.to_owned(), files: files.len(), ..Self::default() };
        let modules: BTreeSet<&str> =
            files.keys().filter(|path| !is_test(path)).map(|path| graph::module_of(path)).collect();
        let mut reaches = Graph::new();
        for (path, text) in files {
            measured.prose.add(text);
            let code = bare(text);
            if is_test(path) {
                measured.tests += code_lines(&code);
                continue;
            }
            let (code, tests) = apart(&code);
            measured.tests += code_lines(&tests);
            measured.add(path, &code);
            let module = graph::module_of(path);
            // Everything may be in the root, and the root reaches everything: it is in no circle.
            if !matches!(module, "lib" | "main") {
                let others = graph::named(path, &code).into_iter().filter(|other| {
                    other != module
                        && !matches!(other.as_str(), "lib" | "main")
                        && modules.contains(other.as_str())
                });
                reaches.entry(module.to_owned()).or_default().extend(others);
            }
        }
        measured.modules = reaches.len();
        measured.circles = graph::circles(&reaches);
        measured
    }

    /// Adds a file without its tests.
    fn add(&mut self, path: &str, code: &str) {
        self.code += code_lines(code);
        self.wildcards += wildcards(code);
        let functions = functions(code);
        for function in &functions {
            let place = format!("{path}: {}", function.name);
            if function.reads_error() {
                self.note(place.clone(), Fault::ReadError);
            }
            if function.lines > LONGEST_FUNCTION {
                self.note(place, Fault::LongFunction { lines: function.lines });
            }
        }
        let function_at = |at| functions.iter().rfind(|function| function.start < at);
        let words: Vec<Word> = words(code).collect();
        for (i, word) in words.iter().enumerate() {
            let place = || {
                let name = function_at(word.start).map_or("?", |function| function.name);
                format!("{path}: {name}")
            };
            if is_string_error(code, &words[i..]) {
                self.note(place(), Fault::StringError);
            }
            if is_read_error(code, *word) {
                self.note(place(), Fault::ReadError);
            }
            if let Some(name) = participle_type(&words[i..]) {
                self.note(format!("{path}: {name}"), Fault::ParticipleType);
            }
        }
        let lines = code.matches('\n').count();
        if lines > LONGEST_FILE {
            self.note(path.to_owned(), Fault::LongFile { lines });
        }
    }

    /// An exception is for a place: two functions of a name in a file are one.
    fn note(&mut self, place: String, fault: Fault) {
        let same = |finding: &&mut Finding| finding.place == place && finding.fault.table() == fault.table();
        match self.findings.iter_mut().find(same) {
            Some(finding) => finding.fault = fault,
            None => self.findings.push(Finding { place, fault }),
        }
    }
}

/// Whether only tests use a file.
fn is_test(path: &str) -> bool {
    path.split('/').any(|part| matches!(part, "tests" | "tests.rs"))
}

/// The number of arms that match anything, whether on a condition or not.
fn wildcards(code: &str) -> usize {
    let is_arm = |word: &Word| {
        let rest = code[word.end..].trim_start();
        word.text == "_" && (rest.starts_with("=>") || rest.starts_with("if "))
    };
    words(code).filter(is_arm).count()
}

/// A function, or one that a trait only declares.
struct Function<'a> {
    /// The place of its `fn`.
    start: usize,
    name: &'a str,
    /// All between its name and its body.
    signature: &'a str,
    /// From the opening brace to the closing one; empty without a body.
    body: &'a str,
    /// From the line of the opening brace to that of the closing one; none without a body.
    lines: usize,
}

impl Function<'_> {
    /// Whether a parameter is an error's text, and a text is taken apart: that the error was made to words elsewhere
    /// is no difference.
    fn reads_error(&self) -> bool {
        let is_text = |word: Word| {
            let declared = self.signature[word.end..].trim_start().strip_prefix(':').map(str::trim_start);
            declared.is_some_and(|kind| kind.starts_with("&str") || kind.starts_with("String"))
        };
        words(self.signature).any(|word| matches!(word.text, "error" | "problem") && is_text(word))
            && words(self.body)
                .any(|word| READS.contains(&word.text) && self.body[..word.start].ends_with('.'))
    }
}

fn functions(code: &str) -> Vec<Function<'_>> {
    let words: Vec<Word> = words(code).collect();
    let mut found = Vec::new();
    for pair in words.windows(2) {
        let [keyword, name] = pair else { continue };
        // The type `fn(Robot)` has no name.
        if keyword.text != "fn" || !code[keyword.end..name.start].trim().is_empty() {
            continue;
        }
        let stop = outside(code, name.end, "()[]").find(|&(_, byte)| matches!(byte, b';' | b'{'));
        let (stop, first) = stop.unwrap_or((code.len(), b';'));
        let body = if first == b'{' { &code[stop..group_end(code, stop)] } else { "" };
        found.push(Function {
            start: keyword.start,
            name: name.text,
            signature: &code[name.end..stop],
            body,
            lines: if body.is_empty() { 0 } else { body.matches('\n').count() + 1 },
        });
    }
    found
}

/// Participles that are no names of types when they stand alone: they say what happened to a thing, and not which.
const PARTICIPLES: [&str; 60] = [
    "Asked",
    "Attached",
    "Awaited",
    "Awarded",
    "Believed",
    "Built",
    "Carried",
    "Changed",
    "Checked",
    "Chosen",
    "Compared",
    "Counted",
    "Described",
    "Detailed",
    "Done",
    "Drawn",
    "Driven",
    "Exceeded",
    "Felt",
    "Fitted",
    "Found",
    "Given",
    "Heard",
    "Held",
    "Issued",
    "Judged",
    "Kept",
    "Known",
    "Listed",
    "Loaded",
    "Lost",
    "Made",
    "Mapped",
    "Measured",
    "Mounted",
    "Named",
    "Noted",
    "Numbered",
    "Owed",
    "Paid",
    "Picked",
    "Placed",
    "Read",
    "Reached",
    "Refused",
    "Replaced",
    "Restored",
    "Said",
    "Seen",
    "Sensed",
    "Sent",
    "Served",
    "Shown",
    "Stepped",
    "Swept",
    "Taken",
    "Told",
    "Tried",
    "Wanted",
    "Written",
];

/// The name of the type that is declared here, if it is a mere participle.
fn participle_type<'a>(words: &[Word<'a>]) -> Option<&'a str> {
    let [keyword, name, ..] = words else { return None };
    let declares = matches!(keyword.text, "struct" | "enum" | "type" | "trait");
    (declares && PARTICIPLES.contains(&name.text)).then_some(name.text)
}

/// Whether these words begin a type whose error is a text: `Result<…, String>`, or `type Err = String`.
fn is_string_error(code: &str, words: &[Word]) -> bool {
    let is_string = |path: &str| path.rsplit("::").next() == Some("String");
    match words {
        [keyword, name, text, ..] if keyword.text == "type" && matches!(name.text, "Err" | "Error") => {
            is_string(text.text) && code[name.end..text.start].trim() == "="
        }
        [result, ..] if result.text == "Result" && code[result.end..].starts_with('<') => {
            parts(inside(code, result.end)).get(1).is_some_and(|error| is_string(error))
        }
        _ => false,
    }
}

/// The names under which an error or its text is known.
const ERRORS: [&str; 4] = ["error", "problem", "message", "words"];
/// The methods that search a text or take it apart.
const READS: [&str; 7] =
    ["contains", "starts_with", "ends_with", "split_once", "rsplit_once", "strip_prefix", "strip_suffix"];

/// Whether this word is an error in whose text something is looked for.
fn is_read_error(code: &str, word: Word) -> bool {
    let rest = code[word.end..].trim_start();
    let text = rest.strip_prefix(".to_string()").or_else(|| rest.strip_prefix("()")).unwrap_or(rest);
    let call = text.trim_start().strip_prefix('.').and_then(|call| call.split_once('('));
    ERRORS.contains(&word.text) && call.is_some_and(|(method, _)| READS.contains(&method))
}

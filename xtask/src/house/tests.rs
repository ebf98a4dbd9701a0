//! Small crates in a folder without Git, each with one thing amiss or none, and the scanner by itself.

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::measure::crates;
use super::prose::{Prose, paragraphs};
use super::report::table;
use super::sources::in_folder;
use super::text::{apart, bare, code_lines};
use super::{EXCEPTIONS, Error, Request, findings};

/// A folder that goes away at the end of its test.
struct Folder(PathBuf);

impl Folder {
    fn with(files: &[(&str, &str)]) -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("house-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let folder = Self(std::env::temp_dir().join(name));
        folder.write(EXCEPTIONS, "");
        for (path, text) in files {
            folder.write(path, text);
        }
        folder
    }

    fn write(&self, path: &str, text: &str) {
        let path = self.0.join(path);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder can be made");
        fs::write(path, text).expect("a file can be written");
    }

    fn findings(&self) -> Vec<String> {
        findings(&self.0).expect("the folder can be measured")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).expect("the folder can be removed");
    }
}

/// The findings in a crate `robot` with one file.
fn found_in(code: &str) -> Vec<String> {
    Folder::with(&[("robot/src/lib.rs", code)]).findings()
}

fn lines(count: usize) -> String {
    "    step();\n".repeat(count)
}

#[test]
fn comments_go_and_lines_stay() {
    assert_eq!(bare("a // \"no string\nb"), "a \nb");
    assert_eq!(bare("/// fn a() {\nfn b() {}"), "\nfn b() {}");
    assert_eq!(bare("a/* one\n/* within */ two\n*/b"), "a \n\nb");
    assert_eq!(bare("a /* never closed\n"), "a  \n");
    assert_eq!(bare("half / track"), "half / track");
}

#[test]
fn strings_are_emptied() {
    assert_eq!(bare(r#"f("a // b", "\"{", b"}\\")"#), r#"f("", "", b"")"#);
    assert_eq!(bare("f(\"one\\\n two\n\") {"), "f(\"\"\n\n) {");
    assert_eq!(bare("\"never closed \\"), "\"\"");
    assert_eq!(bare("\"½ \\½\" + größe"), "\"\" + größe");
}

#[test]
fn raw_strings_end_with_as_many_hashes() {
    assert_eq!(bare(r###"f(r"\", r#"a"b"#, br##"a"#b"##, c"d")"###), r#"f("", "", "", c"")"#);
    assert_eq!(bare("let r#type = r; bar\"a\""), "let r#type = r; bar\"\"");
    assert_eq!(bare("r#\"one\ntwo"), "\"\"\n");
}

#[test]
fn characters_are_emptied_and_lifetimes_stay() {
    assert_eq!(
        bare(r#"['"', '\'', '\\', '\u{1F600}', '½', b'{', b'\x7b']"#),
        "['', '', '', '', '', b'', b'']"
    );
    assert_eq!(bare("fn f<'a, 'b>(x: &'a str, y: &'b u8) {"), "fn f<'a, 'b>(x: &'a str, y: &'b u8) {");
    assert_eq!(bare("'outer: loop { f::<'_>('{') }"), "'outer: loop { f::<'_>('') }");
}

#[test]
fn lines_of_blanks_are_no_code() {
    assert_eq!(code_lines(&bare("// why\n\nfn f() {\n    // why\n    g();\n}\n")), 3);
}

#[test]
fn items_of_tests_are_cut_out() {
    for (item, rest) in [
        ("mod tests {\n    fn f() { g(\"}\") }\n}", ""),
        ("mod tests;", ""),
        ("#[path = \"[.rs\"]\nmod tests;", ""),
        ("use std::{fs, io};", ""),
        ("const SIZES: [u8; 2] = [1, 2];", ""),
        ("pub(crate) fn f<A, B>(x: [u8; 3]) -> u8\nwhere\n    A: B,\n{\n    1\n}", ""),
        ("impl<A, B> Pair<A, B> {\n}", ""),
        ("pub(super) passed: Map<u8, u8>,", " other: u8,"),
        ("last: u8", "\n}"),
        ("Variant { a: u8, b: u8 },", " Other,"),
        ("A if a < b => 1,", " B => 2,"),
        ("check(a, b);", " go();"),
    ] {
        let code = bare(&format!("first;\n#[cfg(test)]\n{item}{rest}\n"));
        let (kept, tests) = apart(&code);
        assert_eq!(kept, format!("first;\n{rest}\n"), "{item}");
        assert_eq!(tests, format!("#[cfg(test)]\n{}\n", bare(item)), "{item}");
    }
}

#[test]
fn only_what_needs_tests_is_for_tests() {
    for (attribute, is_cut) in [
        ("#[cfg(test)]", true),
        ("#[cfg(all(test, unix))]", true),
        ("#[cfg(all(\n    unix,\n    test\n))]", true),
        ("#[cfg(any(test, unix))]", false),
        ("#[cfg(not(test))]", false),
        ("#[cfg(all(any(test, unix), windows))]", false),
        ("#[cfg(testing)]", false),
        ("#[test]", false),
    ] {
        let (_, tests) = apart(&format!("{attribute}\nfn f() {{}}\n"));
        assert_eq!(!tests.is_empty(), is_cut, "{attribute}");
    }
}

#[test]
fn a_function_has_at_most_forty_lines() {
    assert_eq!(found_in(&format!("fn walk(legs: [u8; 6]) {{\n{}}}\n", lines(38))), Vec::<String>::new());
    assert_eq!(
        found_in(&format!("fn walk(legs: [u8; 6]) {{\n{}}}\n", lines(39))),
        ["robot/src/lib.rs: walk: the function has 41 lines, more than 40; split it by what its parts mean"]
    );
    assert_eq!(found_in(&format!("#[cfg(test)]\nfn walk() {{\n{}}}\n", lines(99))), Vec::<String>::new());
}

#[test]
fn a_file_has_at_most_four_hundred_lines_without_its_tests() {
    let tests = format!("#[cfg(test)]\nmod tests {{\n{}}}\n", lines(99));
    assert_eq!(found_in(&format!("{}{tests}", "const A: u8 = 1;\n".repeat(399))), Vec::<String>::new());
    assert_eq!(
        found_in(&"\n".repeat(401)),
        ["robot/src/lib.rs: the file has 401 lines without its tests, more than 400; \
          move its second idea into another"]
    );
}

#[test]
fn no_error_is_a_string() {
    for (code, is_found) in [
        ("pub fn f() -> Result<(), String> {}", true),
        ("pub async fn f<F: Fn(u8) -> u8>(g: F) -> Option<Result<u8, String>> {}", true),
        ("fn f() -> Result<\n    Map<u8, u8>,\n    String,\n> {}", true),
        ("fn f<G>(g: G) -> u8 where G: Fn() -> std::result::Result<(), std::string::String> {}", true),
        ("fn f() { let g = || -> Result<u8, String> { h() }; }", true),
        ("fn f() {} impl FromStr for Pin { type Err = String; }", true),
        ("pub fn f() -> Result<Map<u8, String>, Error> {}", false),
        ("pub fn f() -> Result<(), Vec<String>> {}", false),
        ("fn f() {} impl FromStr for Pin { type Err = PinError; }", false),
        ("#[cfg(test)]\nfn f() -> Result<(), String> {}", false),
    ] {
        let expected = "robot/src/lib.rs: f: an error is a String; give it an error type that names the path";
        let expected = if is_found { vec![expected] } else { vec![] };
        assert_eq!(found_in(code), expected, "{code}");
    }
}

#[test]
fn no_type_is_a_mere_participle() {
    let expected = "robot/src/lib.rs: Found: a type is a thing, and its name a noun, such as `Detection` in place of `Found`";
    for keyword in ["struct", "pub enum", "pub(crate) type", "trait"] {
        assert_eq!(found_in(&format!("{keyword} Found")), [expected], "{keyword}");
    }
    for code in ["struct FoundPath;", "enum Finding { Found }", "fn f(found: Found) {}", "// struct Found"] {
        assert_eq!(found_in(code), Vec::<String>::new(), "{code}");
    }
}

#[test]
fn comments_are_counted_by_paragraphs() {
    for (text, expected) in [
        ("/// A pin.\n/// It is\n/// blue.\nstruct Pin;", vec!["A pin. It is blue."]),
        ("//! A crate.\n//!\n//! - one\n//! - two\n//!   lines", vec!["A crate.", "one", "two lines"]),
        ("// one\n/// two\n\n/// three", vec!["one", "two", "three"]),
        ("let a = 1; // one\nlet b = \"//\"; // two", vec!["one", "two"]),
        ("/// A pin:\n///\n/// ```\n/// // code\n/// ```\n/// That was it.", vec!["A pin:", "That was it."]),
    ] {
        assert_eq!(paragraphs(text), expected, "{text}");
    }
}

#[test]
fn a_clause_is_no_sentence_and_a_question_is_one() {
    for (comment, clauses) in [
        ("// What it weighs.", 1),
        ("/// Where it stands, in metres. Is it there?", 1),
        ("/// How far", 1),
        ("// What does it weigh? Nothing.", 0),
        ("// Whether it stands.", 0),
        ("// It knows what it weighs.", 0),
        ("//! Where-clauses.", 0),
    ] {
        let mut prose = Prose::default();
        prose.add(comment);
        assert_eq!(prose, Prose { comments: 1, clauses }, "{comment}");
    }
}

#[test]
fn a_number_that_may_not_be_exceeded_lets_pass_what_is_there() {
    let folder =
        Folder::with(&[("robot/src/lib.rs", "/// What it is.\nstruct Found;\n// A pin.\nenum Told {}\n")]);
    let clauses = "500 of 1,000 comments begin with What, How, Where, Which, Who or Why as a clause, more than 20; \
                   write sentences with a noun as their subject";
    assert_eq!(folder.findings().len(), 3);
    assert_eq!(folder.findings()[2], clauses);
    folder.write(EXCEPTIONS, "[at_most]\nclause_comments_in_1000 = 500\nparticiples = 2\n");
    assert_eq!(folder.findings(), Vec::<String>::new());
    folder.write(EXCEPTIONS, "[at_most]\nclause_comments_in_1000 = 500\nparticiples = 3\n");
    let spare = "xtask/house.toml: [at_most] participles: is 3, and there are 2; write that";
    assert_eq!(folder.findings(), [spare]);
    folder.write(EXCEPTIONS, "[at_most]\nclause_comments_in_1000 = 499\nparticiples = 1\n");
    assert_eq!(folder.findings().len(), 3);
}

#[test]
fn no_code_reads_the_text_of_an_error() {
    for (code, is_found) in [
        ("error.to_string().contains(\"pin\")", true),
        ("self.problem\n    .to_string()\n    .split_once(':')", true),
        ("status.message().starts_with(\"pin\")", true),
        ("error.kind().contains(\"pin\")", false),
        ("my_error.contains(\"pin\")", false),
        ("error.to_string()", false),
        ("\"error.contains(\"", false),
    ] {
        let expected = "robot/src/lib.rs: f: the words of an error are for people; \
                        give the error a kind, and match on that";
        let expected = if is_found { vec![expected] } else { vec![] };
        assert_eq!(found_in(&format!("fn f() {{\n{code}\n}}\nfn g() {{}}\n")), expected, "{code}");
    }
    for (function, count) in [
        ("fn f(error: &str) -> String { let text = error.to_owned(); text.rsplit_once(\"a\") }", 1),
        ("fn f(problem: String, n: u8) { g(n).split_once(':') }", 1),
        ("fn f(error: &str) -> String { format!(error) }", 0),
        ("fn f(error: &Error) { g().split_once(':') }", 0),
    ] {
        assert_eq!(found_in(function).len(), count, "{function}");
    }
}

#[test]
fn modules_that_reach_each_other_are_a_circle() {
    let circle = ["robot: these modules reach each other in a circle: arm hand; \
                   move what they share into one below them"];
    for (arm, hand) in [
        ("use crate::hand::Hand;", "use crate::arm::Arm;"),
        ("use crate::{base::Base, hand::{Hand, base}};", "use crate::{\n    base,\n    arm,\n};"),
        ("use super::{base, hand};", "fn f(arm: super::arm::Arm) {}"),
    ] {
        let mut files = vec![
            ("robot/src/lib.rs", "mod arm; mod base; mod hand; use crate::arm::Arm;"),
            ("robot/src/arm.rs", arm),
            ("robot/src/hand/mod.rs", hand),
            ("robot/src/base.rs", "use crate::base::Base; #[cfg(test)] use crate::arm::Arm;"),
        ];
        assert_eq!(Folder::with(&files).findings(), circle, "{arm} {hand}");
        files[1].1 = "use super::base; use hand::Hand;";
        assert_eq!(Folder::with(&files).findings(), Vec::<String>::new(), "{hand}");
    }
}

#[test]
fn files_in_a_folder_go_up_to_the_crate() {
    let files = [
        ("robot/src/arm/joint.rs", "use super::super::{hand, base};"),
        ("robot/src/arm/mod.rs", "use joint::Joint;"),
        ("robot/src/hand/finger.rs", "use super::arm; use super::super::super::arm;"),
        ("robot/src/hand/mod.rs", ""),
    ];
    assert_eq!(Folder::with(&files).findings(), Vec::<String>::new());
    let back = [files[0], files[1], ("robot/src/hand/finger.rs", "use super::{super::arm};"), files[3]];
    assert_eq!(Folder::with(&back).findings().len(), 1);
}

#[test]
fn an_exception_passes_what_it_is_for_and_must_be_needed() {
    let walk = format!("fn walk() {{\n{}}}\n", lines(50));
    let folder = Folder::with(&[
        ("robot/src/arm.rs", "use crate::hand;"),
        ("robot/src/hand.rs", "use crate::arm;"),
        ("robot/src/walk.rs", &walk),
    ]);
    let long = "[[long_functions]]\nplace = \"robot/src/walk.rs: walk\"\nreason = \"It has many legs.\"\n";
    let circle = "[[knots]]\ncrate = \"robot\"\nmodules = [\"arm\", \"hand\"]\nreason = \"They hold.\"\n";
    folder.write(EXCEPTIONS, &format!("{long}{circle}"));
    assert_eq!(folder.findings(), Vec::<String>::new());
    folder.write("robot/src/hand.rs", "");
    folder.write("robot/src/walk.rs", "fn walk() {}");
    assert_eq!(
        folder.findings(),
        [
            "xtask/house.toml: [[knots]] robot: nothing needs this exception any more; remove it",
            "xtask/house.toml: [[long_functions]] robot/src/walk.rs: walk: \
             nothing needs this exception any more; remove it",
        ]
    );
}

#[test]
fn an_exception_has_a_reason() {
    let folder = Folder::with(&[]);
    folder.write(EXCEPTIONS, "[[long_files]]\nplace = \"robot/src/lib.rs\"\n");
    let error = findings(&folder.0).expect_err("there is no reason");
    assert!(matches!(error, Error::Exceptions { .. }), "{error:?}");
}

#[test]
fn tests_generated_code_and_what_builds_leave_are_not_checked() {
    let long = format!("pub fn f() -> Result<(), String> {{\n{}}}\n", lines(500));
    let folder = Folder::with(&[
        ("robot/src/arm/tests.rs", &long),
        ("robot/src/tests/arm.rs", &long),
        ("robot/tests/arm.rs", &long),
        ("robot/src/generated/arm.rs", &long),
        ("target/robot/src/arm.rs", &long),
        ("page/node_modules/robot/src/arm.rs", &long),
    ]);
    assert_eq!(folder.findings(), Vec::<String>::new());
    assert_eq!(in_folder(&folder.0).expect("the folder can be read").len(), 4);
}

#[test]
fn the_table_has_a_row_for_each_crate_and_one_for_all() {
    let code = "fn f(n: u8) {\n    match n {\n        1 => a(),\n        _ if n == 2 => b(),\n        _ => c(),\n    }\n}\n";
    let folder = Folder::with(&[
        ("robot/src/lib.rs", "mod arm;\npub fn f() -> Result<(), String> {}\n"),
        ("robot/src/arm.rs", code),
        ("robot/tests/arm.rs", "// why\nfn f() {}\n"),
    ]);
    let table = table(&crates(&in_folder(&folder.0).expect("the folder can be read")));
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split_whitespace().collect()).collect();
    assert_eq!(rows[1], ["robot", "2", "9", "0", "1", "0", "2", "1", "0", "0", "0", "0"], "{table}");
    let beside = "tests and benches beside the crates 1 0 1 0 0 0 0 0 0 1 0";
    assert_eq!(rows[2].join(" "), beside, "{table}");
    assert_eq!(rows[3], ["all", "3", "9", "1", "1", "0", "2", "1", "0", "0", "1", "0"], "{table}");
    assert!(table.contains("\nclause-comments: 0 of 1,000 comments, 20 may be\n"), "{table}");
    assert!(table.contains("\nerrors that are a String:\n  robot: lib.rs: f\n"), "{table}");
}

#[test]
fn arguments_are_known_or_refused() {
    let parse = |arguments: &[&str]| {
        let arguments: Vec<String> = arguments.iter().map(|argument| (*argument).to_owned()).collect();
        Request::parse(&arguments).map(|request| (request.commit, request.check))
    };
    assert_eq!(parse(&[]).expect("the table"), (None, false));
    assert_eq!(parse(&["--check", "--rev", "HEAD~3"]).expect("a check"), (Some("HEAD~3".to_owned()), true));
    assert_eq!(parse(&["--rev=HEAD"]).expect("a commit"), (Some("HEAD".to_owned()), false));
    for refused in ["--rev", "--json", "HEAD"] {
        let error = parse(&[refused]).expect_err("it is not understood");
        assert!(matches!(error, Error::Argument { ref argument } if argument == refused), "{error:?}");
    }
}

//! Files of tokens: what is read, what is refused, what stays as it is.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::time::{Duration, UNIX_EPOCH};

use proptest::prelude::*;

use super::*;
use crate::token::TokenHash;

const HASH: &str = "2c26b46b68ffc68ff99b453c1d30413413422d706483bfa0f98a5e886266e7ae";
const OTHER: &str = "fcde2b2edba56bf408601fb721fe9b5c338d10ee429ea04fae5511b68fbf8fb9";

/// A file with the text, of mode 0600; the folder lives as long as its first value.
fn file(text: &str) -> (tempfile::TempDir, TokenFile) {
    let folder = tempfile::tempdir().unwrap();
    let file = TokenFile::at(folder.path().join("tokens.toml"));
    private::write(file.path(), text).unwrap();
    (folder, file)
}

fn entry(name: &str, hash: &str) -> String {
    format!(
        "[[tokens]]\nname = \"{name}\"\nhash = \"{hash}\"\nrights = [\"observe\"]\ncreated_at = 2026-12-01T08:00:00Z\n"
    )
}

fn new(name: &str, rights: &[&str], expires_at: Option<SystemTime>) -> NewGrant {
    let rights = rights.iter().map(|right| right.parse().unwrap()).collect();
    NewGrant { name: name.parse().unwrap(), rights, expires_at }
}

fn at(seconds: u64) -> SystemTime {
    UNIX_EPOCH + Duration::from_secs(seconds)
}

/// The error of a file with this text, without its path.
fn said(text: &str) -> String {
    let (_folder, file) = file(text);
    let error = file.read().unwrap_err().to_string();
    let path = format!("{}: ", file.path().display());
    error.strip_prefix(&path).unwrap_or_else(|| panic!("{error} does not begin with the file")).to_owned()
}

#[test]
fn a_grant_comes_back_from_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = TokenFile::at(folder.path().join("config/baudbot/tokens.toml"));
    let now = at(1_800_000_000) + Duration::from_millis(700);
    let rights = ["observe", "drive wander/alice", "drive class-*/*"];
    let alice = file.add(new("alice", &rights, Some(at(1_900_000_000))), now).unwrap();
    let bob = file.add(new("bob", &["operate", "train"], None), now).unwrap();
    let [first, second] = &file.read().unwrap()[..] else { panic!("two grants") };
    assert_eq!((first.name.as_str(), first.hash), ("alice", alice.hash()));
    assert_eq!(first.rights.iter().map(ToString::to_string).collect::<Vec<_>>(), rights);
    assert_eq!((first.created_at, first.expires_at), (at(1_800_000_000), Some(at(1_900_000_000))));
    assert_eq!((second.name.as_str(), second.hash, second.expires_at), ("bob", bob.hash(), None));
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!((mode(file.path()), mode(file.path().parent().unwrap())), (0o600, 0o700));
    let text = fs::read_to_string(file.path()).unwrap();
    assert!(!text.contains(&alice.reveal()[8..]), "the token is not in the file");
}

#[test]
fn the_format_is_the_one_that_is_documented() {
    let shown = include_str!("../file.rs").split("//! ```").nth(1).unwrap();
    let text = shown.trim_start_matches("toml").replace("\n//! ", "\n").replace("\n//!", "\n");
    let (_folder, file) = file(&text);
    let [alice] = &file.read().unwrap()[..] else { panic!("one grant in {text}") };
    assert_eq!(alice.to_string(), "observe, drive wander/alice, until 2027-02-01T08:00:00Z");
    assert_eq!(alice.hash, HASH.parse::<TokenHash>().unwrap());
}

#[test]
fn what_is_revoked_is_gone_and_the_rest_stays_as_it_was() {
    let kept = format!("# Of the spring term.\n{}", entry("bob", OTHER));
    let begin = "# Ours.\nversion = 1 # the first\n\n";
    let (_folder, file) = file(&format!("{begin}# A pupil.\n{}\n{kept}# The end.\n", entry("alice", HASH)));
    let gone = file.revoke(&"alice".parse().unwrap()).unwrap();
    assert_eq!(gone.hash.to_string(), HASH);
    assert_eq!(
        fs::read_to_string(file.path()).unwrap(),
        format!("{begin}\n{kept}# The end.\n").replace("\n\n\n", "\n\n")
    );
    let carol = file.add(new("carol", &["observe"], None), at(0)).unwrap();
    let text = fs::read_to_string(file.path()).unwrap();
    assert!(text.contains(&kept) && text.contains(&carol.hash().to_string()), "{text}");
    let error = file.revoke(&"alice".parse().unwrap()).unwrap_err().to_string();
    assert!(error.ends_with("tokens.toml: has no token `alice`; it has `bob`, `carol`"), "{error}");
}

#[test]
fn lists_that_are_written_as_values_can_be_changed_too() {
    let inline = |name: &str, hash: &str| {
        format!(
            "{{ name = \"{name}\", hash = \"{hash}\", rights = [\"train\"], created_at = \"2026-12-01T08:00:00Z\" }}"
        )
    };
    let (_folder, file) =
        file(&format!("version = 1\ntokens = [{}, {}]\n", inline("a", HASH), inline("b", OTHER)));
    file.revoke(&"a".parse().unwrap()).unwrap();
    file.add(new("c", &["observe"], None), at(0)).unwrap();
    let names: Vec<_> = file.read().unwrap().into_iter().map(|grant| grant.name.to_string()).collect();
    assert_eq!(names, ["b", "c"]);
    let (_folder, file) = self::file("version = 1\ntokens = []\n");
    file.add(new("c", &["observe"], None), at(0)).unwrap();
    assert_eq!(file.read().unwrap().len(), 1);
}

#[test]
fn a_name_is_given_once() {
    let (_folder, file) = file(&format!("version = 1\n{}", entry("alice", HASH)));
    let before = fs::read_to_string(file.path()).unwrap();
    let error = file.add(new("alice", &["observe"], None), at(0)).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "tokens.toml: has a token `alice` already; take another name, or revoke that one first"
        ),
        "{error}"
    );
    assert_eq!(fs::read_to_string(file.path()).unwrap(), before);
}

#[test]
fn an_error_names_the_file_the_field_and_the_remedy() {
    let with = |old: &str, new: &str| {
        let text = format!("version = 1\n{}{}", entry("alice", HASH), entry("bob", OTHER));
        assert!(text.contains(old), "{old}");
        // In the last entry, or else the only place.
        let place = text.rfind(old).unwrap();
        said(&format!("{}{new}{}", &text[..place], &text[place + old.len()..]))
    };
    assert_eq!(
        with("observe", "obsrve"),
        "tokens[1].rights[0]: `obsrve` is not a right; rights are `observe`, `operate`, `train` and `drive WORLD/ROBOT` (token `bob`)"
    );
    assert_eq!(
        with("\"observe\"", ""),
        "tokens[1].rights: is empty, so that the token allows nothing; add a right, or remove the token (token `bob`)"
    );
    assert_eq!(
        with("rights", "right"),
        "tokens[1].right: unknown field `right`, expected one of `name`, `hash`, `rights`, `created_at`, `expires_at`; did you mean `rights`? (token `bob`)"
    );
    assert_eq!(
        with(OTHER, "xyz"),
        "tokens[1].hash: must be the SHA-256 of a token's text, 64 digits in 0-9 and a-f (token `bob`)"
    );
    assert_eq!(
        with("bob", "b b"),
        "tokens[1].name: must be 1 to 64 letters, digits, `_`, `-`, `.` or `@`, is `b b`"
    );
    assert_eq!(
        with("bob", "alice"),
        "tokens[1].name: is the name of tokens[0], too; names must be unique (token `alice`)"
    );
    assert_eq!(
        with(OTHER, HASH),
        "tokens[1].hash: is that of tokens[0], too; a token has one entry, with all its rights (token `bob`)"
    );
    for name in ["local", "nobody"] {
        assert_eq!(
            with("bob", name),
            format!(
                "tokens[1].name: `{name}` is a name that logs use for others; choose another name (token `{name}`)"
            )
        );
    }
    let date = "must be a date from 1970 to 9999 with its time and offset, such as 2027-01-31T12:00:00Z";
    assert_eq!(with("T08:00:00Z", ""), format!("tokens[1].created_at: {date} (token `bob`)"));
    assert_eq!(
        with("T08:00:00Z", "T08:00:00Z\nexpires_at = \"soon\""),
        format!("tokens[1].expires_at: {date} (token `bob`)")
    );
    assert_eq!(
        with("created_at = 2026-12-01T08:00:00Z", ""),
        "tokens[1]: missing field `created_at` (token `bob`)"
    );
    assert_eq!(with("name = \"bob\"", "name = 7"), "tokens[1].name: must be a string, is 7");
    assert_eq!(
        said("version = 1\ntoken = []"),
        "token: unknown field `token`, expected `version` or `tokens`"
    );
    assert_eq!(said("version = 1\ntokens = 5"), "tokens: must be a list, is 5");
}

#[test]
fn the_version_is_looked_at_first() {
    assert_eq!(said(""), "version: is missing; write `version = 1` at the beginning of the file");
    assert_eq!(
        said("version = 2\nkeys = []"),
        "version: is 2, and this program reads 1; use the program that wrote the file, or a later one"
    );
    for wrong in ["0", "-1", "\"1\"", "1.0"] {
        assert_eq!(said(&format!("version = {wrong}")), "version: must be 1");
    }
}

#[test]
fn what_is_no_toml_is_refused_with_the_line() {
    let said = said("version = 1\n\n[[tokens]\n");
    assert!(said.starts_with("line 3: "), "{said}");
    assert!(!said.contains('\n'), "{said}");
}

#[test]
fn thousands_of_tokens_are_read_and_a_huge_file_is_not() {
    let entries: String = (0..5000).map(|i| entry(&format!("t{i}"), &format!("{i:064x}")) + "\n").collect();
    let (_folder, file) = file(&format!("version = 1\n{entries}"));
    assert_eq!(file.read().unwrap().len(), 5000);
    file.add(new("last", &["observe"], None), at(0)).unwrap();
    assert_eq!(file.read().unwrap().len(), 5001);
    private::write(file.path(), &format!("version = 1\n#{}\n", "x".repeat(16 << 20))).unwrap();
    let error = file.read().unwrap_err();
    assert!(matches!(error, FileError::File(PrivateError::TooLong { most: 16_777_216, .. })), "{error}");
}

#[test]
fn a_file_that_others_can_write_to_is_neither_read_nor_changed() {
    let text = format!("version = 1\n{}", entry("alice", HASH));
    let (_folder, file) = file(&text);
    fs::set_permissions(file.path(), fs::Permissions::from_mode(0o664)).unwrap();
    let chmod = format!("chmod 600 {}", file.path().display());
    for error in [
        file.read().unwrap_err(),
        file.add(new("bob", &["observe"], None), at(0)).unwrap_err(),
        file.revoke(&"alice".parse().unwrap()).unwrap_err(),
    ] {
        assert!(error.to_string().ends_with(&chmod), "{error}");
    }
    assert_eq!(fs::read_to_string(file.path()).unwrap(), text);
}

#[test]
fn commands_at_once_lose_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let file = TokenFile::at(folder.path().join("tokens.toml"));
    file.add(new("old", &["observe"], None), at(0)).unwrap();
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let file = &file;
            scope.spawn(move || {
                for i in 0..8 {
                    file.add(new(&format!("t{thread}-{i}"), &["observe"], None), at(0)).unwrap();
                }
            });
        }
        scope.spawn(|| file.revoke(&"old".parse().unwrap()).unwrap());
    });
    let names: std::collections::BTreeSet<_> =
        file.read().unwrap().into_iter().map(|grant| grant.name.to_string()).collect();
    assert_eq!(names.len(), 32);
    assert!(!names.contains("old"));
}

#[test]
fn there_is_nothing_to_revoke_without_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = TokenFile::at(folder.path().join("none/tokens.toml"));
    let error = file.revoke(&"alice".parse().unwrap()).unwrap_err().to_string();
    assert!(error.starts_with("cannot read ") && error.contains("No such file"), "{error}");
    assert!(!folder.path().join("none").exists());
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in ".*", tail in "[a-z0-9\\[\\]{}=\" .\\n:TZ-]{0,60}") {
        let path = Path::new("tokens.toml");
        let _ = parse::grants(path, &text);
        let whole = format!("version = 1\n{}{tail}", entry("alice", HASH));
        if let Ok(grants) = parse::grants(path, &whole) {
            // A file that can be read can be changed, and read again.
            let less = edit::without(&whole, 0).unwrap();
            prop_assert_eq!(parse::grants(path, &less).unwrap().len() + 1, grants.len());
            let more = edit::with(&less, &grants[0]).unwrap();
            prop_assert_eq!(parse::grants(path, &more).unwrap().len(), grants.len());
        }
    }
}

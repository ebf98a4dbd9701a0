//! `baudbot token` and `baudbot cert`.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use serde_json::Value;

use crate::cli::{baudbot, command, good, place, said};

fn mode(path: &Path) -> u32 {
    fs::metadata(path).unwrap().permissions().mode() & 0o777
}

#[test]
fn a_token_is_alone_on_stdout_and_only_its_hash_is_kept() {
    let path = place("new-tokens").join("tokens.toml");
    let _ = fs::remove_dir_all(path.parent().unwrap());
    let file = path.to_str().unwrap();
    let (code, _, err) = baudbot(&["token", "list", "--file", file]);
    let absent =
        format!("error: {file} does not exist yet; `baudbot token new --name NAME --operate` creates it\n");
    assert_eq!((code, err), (2, absent));
    let rights = ["--observe", "--drive", "wander/alice", "--drive", "class-*/*", "--expires", "30d"];
    let (code, out, err) =
        baudbot(&[&["token", "new", "--name", "alice", "--file", file], &rights[..]].concat());
    assert_eq!(code, 0, "{err}");
    let token = out.strip_suffix('\n').unwrap();
    assert!(
        token.starts_with("baudbot_") && token.len() == 51 && !token.contains(char::is_whitespace),
        "{out}"
    );
    assert!(err.starts_with("alice: observe, drive wander/alice, drive class-*/*, until 2"), "{err}");
    assert!(!err.contains(token) && err.contains(file), "{err}");
    let text = fs::read_to_string(&path).unwrap();
    assert!(
        !text.contains(token)
            && text.contains("rights = [\"observe\", \"drive wander/alice\", \"drive class-*/*\"]"),
        "{text}"
    );
    assert_eq!((mode(&path), mode(path.parent().unwrap())), (0o600, 0o700));
    let listed: Value = serde_json::from_str(&good(&["token", "list", "--json", "--file", file])).unwrap();
    assert_eq!(listed[0]["name"], "alice");
    assert_eq!(listed[0]["rights"][1], "drive wander/alice");
    assert_eq!(listed[0]["expired"], false);
    let table = good(&["token", "list", "--file", file]);
    assert!(table.starts_with("name   rights ") && table.lines().count() == 2, "{table}");
    let (code, out, err) = baudbot(&["token", "revoke", "alice", "--file", file]);
    assert_eq!((code, out.as_str()), (0, ""), "{err}");
    assert!(err.starts_with("alice is revoked: observe, "), "{err}");
    let (code, out, err) = baudbot(&["token", "list", "--file", file]);
    assert_eq!((code, out, err), (0, String::new(), format!("{file} has no tokens\n")));
}

#[test]
fn tokens_are_kept_in_the_folder_of_settings() {
    let home = place("home-of-tokens");
    let _ = fs::remove_dir_all(&home);
    let settings = home.join("settings");
    let new = |name: &str| {
        let mut command = command(&["token", "new", "--observe", "--name", name]);
        command.env("HOME", &home).env_remove("XDG_CONFIG_HOME");
        command
    };
    let (code, _, err) = said(new("alice").output().unwrap());
    assert_eq!(code, 0, "{err}");
    assert!(home.join(".config/baudbot/tokens.toml").is_file());
    let (code, _, err) = said(new("alice").env("XDG_CONFIG_HOME", &settings).output().unwrap());
    assert_eq!(code, 0, "{err}");
    assert!(settings.join("baudbot/tokens.toml").is_file());
    let nowhere = new("alice").env_remove("HOME").output().unwrap();
    assert_eq!(
        said(nowhere).2,
        "error: there is no home folder to keep tokens in; name a file with --file\n"
    );
}

#[test]
fn what_makes_no_sense_of_a_token_is_refused() {
    let path = place("refused-tokens.toml");
    let _ = fs::remove_file(&path);
    let file = path.to_str().unwrap();
    let refused = |args: &[&str]| {
        let (code, out, err) = baudbot(&[args, &["--file", file]].concat());
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        err
    };
    let err = refused(&["token", "new", "--name", "alice"]);
    assert!(err.contains("--observe|--operate|--train|--drive <WORLD/ROBOT>"), "{err}");
    let err = refused(&["token", "new", "--name", "alice", "--drive", "alice"]);
    assert!(err.contains("write WORLD/ROBOT, such as wander/alice, or */* for all robots"), "{err}");
    let err = refused(&["token", "new", "--name", "a b", "--observe"]);
    assert!(err.contains("must be 1 to 64 letters"), "{err}");
    let err = refused(&["token", "new", "--name", "alice", "--observe", "--expires", "30"]);
    assert!(err.contains("write a whole number with a unit: 90m, 12h, 30d or 8w"), "{err}");
    assert!(!path.exists());
    let new = ["token", "new", "--name", "alice", "--observe", "--file", file];
    assert_eq!(baudbot(&new).0, 0);
    let err = refused(&new[..5]);
    assert_eq!(
        err,
        format!("error: {file}: has a token `alice` already; take another name, or revoke that one first\n")
    );
    let err = refused(&["token", "revoke", "bob"]);
    assert_eq!(err, format!("error: {file}: has no token `bob`; it has `alice`\n"));
    fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).unwrap();
    let err = refused(&["token", "list"]);
    assert_eq!(
        err,
        format!("error: {file}: others can read or write it (mode 0644); fix that with: chmod 600 {file}\n")
    );
}

#[test]
fn a_token_that_cannot_be_printed_is_not_kept() {
    let path = place("unprinted-tokens.toml");
    let _ = fs::remove_file(&path);
    let file = path.to_str().unwrap();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut new = command(&["token", "new", "--name", "alice", "--observe", "--file", file]);
    let output = new.stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(
        serde_json::from_str::<Value>(&good(&["token", "list", "--json", "--file", file])).unwrap(),
        Value::Array(Vec::new())
    );
}

#[test]
fn an_authority_makes_certificates() {
    let folder = place("certificates");
    let _ = fs::remove_dir_all(&folder);
    let lab = folder.to_str().unwrap();
    let out = good(&["cert", "ca", lab]);
    assert!(
        out.starts_with(&format!("{lab}/ca.pem, valid until "))
            && out.ends_with("/ca-key.pem, which is secret\n"),
        "{out}"
    );
    good(&["cert", "server", lab, "robots.lab", "10.0.0.7", "::1"]);
    good(&["cert", "client", lab, "alice", "--expires", "30d"]);
    for name in ["ca", "robots.lab", "alice"] {
        assert_eq!(mode(&folder.join(format!("{name}-key.pem"))), 0o600);
        let certificate = fs::read_to_string(folder.join(format!("{name}.pem"))).unwrap();
        assert!(certificate.starts_with("-----BEGIN CERTIFICATE-----\n"), "{certificate}");
    }
    let refused = |args: &[&str]| {
        let (code, out, err) = baudbot(args);
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        err
    };
    let there = "already exists; move it away, or choose another folder or name\n";
    assert_eq!(refused(&["cert", "ca", lab]), format!("error: {lab}/ca-key.pem: {there}"));
    assert_eq!(refused(&["cert", "client", lab, "alice"]), format!("error: {lab}/alice-key.pem: {there}"));
    let err = refused(&["cert", "server", lab, "robots.lab:7400"]);
    assert!(
        err.contains("`robots.lab:7400` is not the name of a server") && err.contains("without a port"),
        "{err}"
    );
    let err = refused(&["cert", "client", lab, "bob", "--expires", "5000d"]);
    assert!(err.contains("its authority ends before"), "{err}");
    let (code, _, err) = baudbot(&["cert", "client", "nowhere", "bob"]);
    assert!(code == 1 && err.contains("cannot read nowhere/ca-key.pem: No such file"), "{err}");
}

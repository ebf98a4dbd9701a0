//! `baudbot token`: makes, lists and revokes what clients show to a server.

use std::time::SystemTime;

use anyhow::Context;
use baudbot_access::{FileError, Grant, NewGrant, PrivateError, Right, TokenFile, date, local};
use baudbot_plot::text::columns;
use serde::Serialize;

use crate::args::{ListTokensArgs, NewTokenArgs, RevokeTokenArgs, TokenCommand, TokenFileArgs};
use crate::error::Refused;
use crate::text;
use crate::text::tell;

pub(crate) fn token(command: TokenCommand) -> anyhow::Result<()> {
    match command {
        TokenCommand::New(args) => new(args),
        TokenCommand::List(args) => list(&args),
        TokenCommand::Revoke(args) => revoke(&args),
        TokenCommand::Local(args) => own(&args.connect),
    }
}

/// The token of the user's own server.
fn own(address: &str) -> anyhow::Result<()> {
    let token = local::find(address).map_err(|error| Refused::error(error.to_string()))?;
    let Some(token) = token else {
        let text = format!(
            "there is no token of yours for {address}; is `baudbot serve` running there, without --open?"
        );
        return Err(anyhow::anyhow!(text));
    };
    text::print(&format!("{}\n", token.reveal()))
}

fn new(args: NewTokenArgs) -> anyhow::Result<()> {
    let file = file(&args.file)?;
    let now = SystemTime::now();
    let end =
        args.expires.map(|lifetime| lifetime.after(now).context("--expires: the clock does not go that far"));
    let plain = [(args.observe, Right::Observe), (args.operate, Right::Operate), (args.train, Right::Train)];
    let plain = plain.into_iter().filter_map(|(given, right)| given.then_some(right));
    let rights: Vec<_> = plain.chain(args.drive.into_iter().map(Right::Drive)).collect();
    let new = NewGrant { name: args.name.clone(), rights, expires_at: end.transpose()? };
    let words = new.to_string();
    let token = file.add(new, now).map_err(refused)?;
    // A token that was not printed is lost, so it is revoked.
    if let Err(error) = text::print(&format!("{}\n", token.reveal())) {
        let _ = file.revoke(&args.name);
        return Err(error);
    }
    tell!(
        "{}: {words}. {} has its hash; the token itself is shown only now.",
        args.name,
        file.path().display()
    );
    Ok(())
}

fn list(args: &ListTokensArgs) -> anyhow::Result<()> {
    let file = file(&args.file)?;
    let grants = file.read().map_err(|error| {
        if error.is_absent() {
            let path = file.path().display();
            return Refused::error(format!(
                "{path} does not exist yet; `baudbot token new --name NAME --operate` creates it"
            ));
        }
        refused(error)
    })?;
    let now = SystemTime::now();
    if args.json {
        return text::print_json(&grants.iter().map(|grant| Row::new(grant, now)).collect::<Vec<_>>());
    }
    if grants.is_empty() {
        tell!("{} has no tokens", file.path().display());
        return Ok(());
    }
    let head = ["name", "rights", "created", "expires"].map(str::to_owned);
    let rows = grants.iter().map(|grant| {
        let Row { name, rights, created_at, expires_at, expired } = Row::new(grant, now);
        let end = expires_at.unwrap_or_else(|| "never".to_owned());
        let end = if expired { format!("{end} (expired)") } else { end };
        [name, rights.join(", "), created_at, end]
    });
    let rows: Vec<_> = std::iter::once(head).chain(rows).collect();
    text::print(&columns("", &rows, |_| true))
}

fn revoke(args: &RevokeTokenArgs) -> anyhow::Result<()> {
    let file = file(&args.file)?;
    let grant = file.revoke(&args.name).map_err(refused)?;
    tell!("{} is revoked: {grant}", args.name);
    Ok(())
}

/// A grant as JSON.
#[derive(Serialize)]
struct Row {
    name: String,
    rights: Vec<String>,
    created_at: String,
    expires_at: Option<String>,
    expired: bool,
}

impl Row {
    fn new(grant: &Grant, now: SystemTime) -> Self {
        Self {
            name: grant.name.to_string(),
            rights: grant.rights.iter().map(ToString::to_string).collect(),
            created_at: date::print(grant.created_at),
            expires_at: grant.expires_at.map(date::print),
            expired: grant.has_expired(now),
        }
    }
}

fn file(args: &TokenFileArgs) -> anyhow::Result<TokenFile> {
    let file = args.file.clone().map(TokenFile::at).or_else(TokenFile::usual);
    file.ok_or_else(|| Refused::error("there is no home folder to keep tokens in; name a file with --file"))
}

/// A wrong file or name has to be changed, a system's refusal is a failure.
fn refused(error: FileError) -> anyhow::Error {
    match error {
        FileError::File(PrivateError::Io { .. } | PrivateError::Locked { .. }) | FileError::Random(_) => {
            error.into()
        }
        FileError::File(_)
        | FileError::Toml { .. }
        | FileError::Field { .. }
        | FileError::Taken { .. }
        | FileError::Reserved { .. }
        | FileError::Absent { .. } => Refused::error(error.to_string()),
    }
}

//! The word to programs that a server is ready: a file with its address, and a line of JSON.

use std::io::ErrorKind;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context;
use baudbot_server::Server;
use baudbot_sim::Scenario;
use serde_json::json;

use crate::text;

/// The ways in which programs hear that a server is ready.
#[derive(Debug, Default)]
pub(crate) struct Announcement {
    /// The file that gets the first address.
    pub(crate) port_file: Option<PathBuf>,
    /// Whether a line of JSON is all that stdout gets.
    pub(crate) json: bool,
}

impl Announcement {
    /// Removes the file of an earlier server, whose address would be taken for this one's.
    ///
    /// # Errors
    /// If it cannot be removed.
    pub(crate) fn prepare(&self) -> anyhow::Result<()> {
        let Some(path) = &self.port_file else { return Ok(()) };
        match std::fs::remove_file(path) {
            Ok(()) => Ok(()),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
            Err(error) => {
                Err(error).with_context(|| format!("--port-file {}: cannot be replaced", path.display()))
            }
        }
    }

    /// Prints a text for people, unless stdout is for programs.
    ///
    /// # Errors
    /// If nobody reads stdout any more.
    pub(crate) fn people(&self, words: &str) -> anyhow::Result<()> {
        if self.json { Ok(()) } else { text::print(words) }
    }

    /// Says that the server is ready.
    ///
    /// # Errors
    /// If the file cannot be written, or nobody reads stdout any more.
    pub(crate) fn ready(&self, server: &Server, live: &[(String, Arc<Scenario>)]) -> anyhow::Result<()> {
        let connect = server.client_address().map(|(address, _)| address);
        if let (Some(path), Some(address)) = (&self.port_file, &connect) {
            text::replace(path, &format!("{address}\n")).context("--port-file")?;
        }
        if !self.json {
            return Ok(());
        }
        let worlds: Vec<_> = live
            .iter()
            .map(|(world, scenario)| {
                let robots: Vec<_> = scenario.robots.iter().map(|spec| spec.name.as_str()).collect();
                json!({ "world": world, "robots": robots })
            })
            .collect();
        text::print_json_line(&json!({
            "connect": connect,
            "trainers": server.trainers().iter().map(ToString::to_string).collect::<Vec<_>>(),
            "viewer": server.viewer_links().first(),
            "worlds": worlds,
        }))
    }
}

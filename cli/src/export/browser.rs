//! A browser without a window, with a profile of its own that is gone when it is.

use std::env;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::PathBuf;
use std::process::{ExitStatus, Stdio};

use anyhow::Context;
use rustix::process::{Pid, Signal, geteuid, kill_process_group};
use tempfile::TempDir;
use tokio::process::{Child, Command};

use crate::error::Refused;

/// A browser that shows a page. It ends when this is dropped.
pub(super) struct Browser {
    child: Child,
    /// All processes that it starts are in one group, which has this number.
    group: Option<Pid>,
    /// The output of the browser.
    log: File,
    /// Dropped last: it is where the browser writes.
    _profile: TempDir,
}

/// A browser's program.
pub(super) fn find() -> anyhow::Result<PathBuf> {
    if let Some(named) = env::var_os(VARIABLE).filter(|named| !named.is_empty()) {
        let found = in_path(&named.to_string_lossy());
        let named = named.to_string_lossy().into_owned();
        return found.ok_or_else(|| {
            Refused::error(format!("{VARIABLE}: there is no program `{named}`; name a Chromium or a Chrome"))
        });
    }
    NAMES.iter().find_map(|name| in_path(name)).ok_or_else(|| {
        Refused::error(format!(
            "a film needs a browser, and there is none of {} in PATH; install one (on Debian and Ubuntu: apt install \
             chromium), or name one with {VARIABLE}=/path/to/chromium",
            NAMES.join(", ")
        ))
    })
}

/// A program by its path, or by its name in one of the folders of PATH.
fn in_path(name: &str) -> Option<PathBuf> {
    if name.contains('/') {
        return Some(PathBuf::from(name)).filter(|path| path.is_file());
    }
    let folders = env::var_os("PATH")?;
    env::split_paths(&folders).map(|folder| folder.join(name)).find(|path| path.is_file())
}

impl Browser {
    /// Starts it with this page.
    pub(super) fn open(program: &PathBuf, url: &str, width_px: u32) -> anyhow::Result<Self> {
        let profile = tempfile::Builder::new().prefix("baudbot-film-").tempdir();
        let profile = profile.context("cannot make a folder for the browser's profile")?;
        let log = tempfile::tempfile().context("cannot create a file for the browser's output")?;
        let both = || log.try_clone().map(Stdio::from).context("cannot share a file");
        let mut command = Command::new(program);
        command.args(OPTIONS).arg(format!("--user-data-dir={}", profile.path().display()));
        command.arg(format!("--window-size={width_px},{}", width_px.max(LEAST_HEIGHT_PX)));
        if geteuid().is_root() {
            // As root it has no other choice, and it shows nothing but our own page.
            command.arg("--no-sandbox");
        }
        command
            .arg(url)
            .stdin(Stdio::null())
            .stdout(both()?)
            .stderr(both()?)
            .process_group(0)
            .kill_on_drop(true);
        let child = command.spawn().with_context(|| format!("cannot start {}", program.display()))?;
        let group = child.id().and_then(|id| Pid::from_raw(id.cast_signed()));
        Ok(Self { child, group, log, _profile: profile })
    }

    /// Waits for its end.
    pub(super) async fn ended(&mut self) -> std::io::Result<ExitStatus> {
        self.child.wait().await
    }

    /// The last lines of the browser's output.
    pub(super) fn last_words(&mut self) -> String {
        let mut said = Vec::new();
        let read = self.log.seek(SeekFrom::Start(0)).and_then(|_| self.log.read_to_end(&mut said));
        let said = String::from_utf8_lossy(&said);
        let lines: Vec<_> = said.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        match (read, lines.as_slice()) {
            (Ok(_), [.., last]) => format!(" (its last message: {last})"),
            _ => String::new(),
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // The group includes the browser's helpers; those of one that has ended end by themselves, or now.
        if let Some(group) = self.group {
            let _ = kill_process_group(group, Signal::KILL);
        }
    }
}

/// Names a browser.
const VARIABLE: &str = "BAUDBOT_BROWSER";

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// Options of the browser: no window, no dialogs, no network access of its own, and no throttling in the background.
const OPTIONS: [&str; 13] = [
    "--headless=new",
    "--no-first-run",
    "--no-default-browser-check",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-extensions",
    "--disable-dev-shm-usage",
    "--disable-background-timer-throttling",
    "--disable-renderer-backgrounding",
    "--disable-backgrounding-occluded-windows",
    "--hide-scrollbars",
    "--mute-audio",
];

/// The height of a window in which the page has room.
const LEAST_HEIGHT_PX: u32 = 720;

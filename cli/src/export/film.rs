//! Films: the viewer's own page draws them, in a browser without a window, from a private server.

use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, anyhow, bail};
use baudbot_recording::{RecordedRun, Watched};
use baudbot_server::{Film, Server, WorldConfig};
use indicatif::ProgressBar;
use tokio::sync::mpsc;

use super::browser::{self, Browser};
use super::window::Window;
use super::{Out, name, start};
use crate::args::{ExportArgs, FilmArgs, Theme};
use crate::error::{Refused, from_builder};
use crate::output_files;
use crate::signals::Stop;

/// The films that are wanted.
pub(super) struct Films<'a> {
    args: &'a ExportArgs,
    browser: PathBuf,
    wanted: Vec<Wanted>,
    from_s: f64,
    to_s: f64,
    pictures: f64,
}

struct Wanted {
    kind: Kind,
    name: String,
    out: Out,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Gif,
    Webm,
}

impl Kind {
    fn word(self) -> &'static str {
        match self {
            Self::Gif => "gif",
            Self::Webm => "webm",
        }
    }

    /// The first bytes of such a file.
    fn magic(self) -> &'static [u8] {
        match self {
            Self::Gif => b"GIF8",
            Self::Webm => &[0x1A, 0x45, 0xDF, 0xA3],
        }
    }
}

impl<'a> Films<'a> {
    /// Opens the files, and refuses what would never end.
    pub(super) fn new(args: &'a ExportArgs, recorded: &RecordedRun, window: &Window) -> anyhow::Result<Self> {
        let step_s = recorded.header().step_ns as f64 / 1e9;
        let (from_s, to_s) = (window.from_tick as f64 * step_s, window.to_tick as f64 * step_s);
        let pictures = ((to_s - from_s) / args.film.speed * f64::from(args.film.fps)).floor() + 1.0;
        let mut films = Self { args, browser: PathBuf::new(), wanted: Vec::new(), from_s, to_s, pictures };
        if args.gif.is_none() && args.webm.is_none() {
            return Ok(films);
        }
        if pictures > MOST_PICTURES {
            return Err(Refused::error(format!(
                "the film would have {pictures} pictures, and at most {MOST_PICTURES} are possible; take a part of the run \
                 (--from-s, --to-s), a higher --speed or a lower --fps"
            )));
        }
        films.browser = browser::find()?;
        films.add(Kind::Gif, args.gif.as_deref())?;
        films.add(Kind::Webm, args.webm.as_deref())?;
        Ok(films)
    }

    fn add(&mut self, kind: Kind, path: Option<&Path>) -> anyhow::Result<()> {
        let Some(path) = path else { return Ok(()) };
        let name = name(path);
        let out = output_files::open(path).with_context(|| format!("cannot write {name}"))?;
        self.wanted.push(Wanted { kind, name, out });
        Ok(())
    }

    /// Makes them, one after the other. Returns whether it came to its end, before a signal did.
    pub(super) async fn make(
        &mut self,
        recorded: &Arc<RecordedRun>,
        stop: &mut Stop,
    ) -> anyhow::Result<bool> {
        if self.wanted.is_empty() {
            return Ok(true);
        }
        let (films, mut made) = mpsc::channel(1);
        let world = recorded.header().world.clone();
        let replay =
            WorldConfig::replay(world.clone(), start(&self.args.file, recorded, Watched::default())?);
        let place = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let server = Server::builder().world(replay).viewer(place).films(films).serve().await;
        let server = server.map_err(from_builder)?;
        let viewer = *server.viewers().first().context("the server has no viewer")?;
        let mut is_whole = true;
        for wanted in std::mem::take(&mut self.wanted) {
            let url = url(viewer, wanted.kind, &world, (self.from_s, self.to_s), &self.args.film);
            tokio::select! {
                film = self.wait(&url, &mut made) => keep(wanted, &film?)?,
                () = stop.wait() => {
                    is_whole = false;
                    break;
                }
            }
        }
        // The browser is gone by now, and with it what would keep connections open.
        let _ = tokio::time::timeout(PATIENCE, server.shutdown()).await;
        Ok(is_whole)
    }

    /// Waits for what the page makes.
    async fn wait(&self, url: &str, made: &mut mpsc::Receiver<Film>) -> anyhow::Result<Vec<u8>> {
        let limit = LEAST_LIMIT + LIMIT_A_PICTURE.mul_f64(self.pictures);
        let bar = self.spinner();
        let mut browser = Browser::open(&self.browser, url, self.args.film.width_px)?;
        let film = tokio::select! {
            film = made.recv() => film.context("the server has ended")?,
            status = browser.ended() => {
                let status = status.context("cannot wait for the browser")?;
                bail!("the browser ended without a film: {status}{}", browser.last_words());
            }
            () = tokio::time::sleep(limit) => {
                let words = browser.last_words();
                bail!("the browser made no film within {} s{words}", limit.as_secs());
            }
        };
        bar.finish_and_clear();
        film.map_err(|problem| anyhow!("the page made no film: {problem}"))
    }

    fn spinner(&self) -> ProgressBar {
        if self.args.quiet {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new_spinner().with_message(format!("filming {} pictures", self.pictures));
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }
}

/// The page that makes a film, and posts it.
fn url(viewer: SocketAddr, kind: Kind, world: &str, (from_s, to_s): (f64, f64), args: &FilmArgs) -> String {
    let FilmArgs { fps, speed, width_px, theme } = args;
    let (film, theme) = (
        kind.word(),
        match theme {
            Theme::Light => "light",
            Theme::Dark => "dark",
        },
    );
    // Names of worlds have letters, digits, `_` and `-` only.
    format!(
        "http://{viewer}/?film={film}&world={world}&from_s={from_s}&to_s={to_s}&speed={speed}&fps={fps}\
         &width={width_px}&theme={theme}&post=/film"
    )
}

fn keep(Wanted { kind, name, mut out }: Wanted, film: &[u8]) -> anyhow::Result<()> {
    if !film.starts_with(kind.magic()) {
        bail!("the page did not make a valid {} ({} bytes); {name} is unchanged", kind.word(), film.len());
    }
    out.write_all(film).and_then(|()| out.flush()).with_context(|| format!("cannot write {name}"))
}

/// The page has no room for more.
const MOST_PICTURES: f64 = 20_000.0;
/// A browser that has made no film by then makes none.
const LEAST_LIMIT: Duration = Duration::from_secs(120);
const LIMIT_A_PICTURE: Duration = Duration::from_secs(1);
/// The time that connections have to close.
const PATIENCE: Duration = Duration::from_secs(3);

//! The log on stderr, and, if asked for, the export of traces to a collector.

#[cfg(feature = "otel")]
mod otel;

use std::io::{self, IsTerminal, Write};
use std::str::FromStr;

use crate::text;
use crate::text::tell;
use baudbot_fields::printable::Printable;
use clap::ValueEnum;
use tracing_subscriber::field::RecordFields;
use tracing_subscriber::filter::{FilterExt, LevelFilter, Targets, filter_fn};
use tracing_subscriber::fmt::format::{DefaultFields, FormatFields, Writer};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Layer, Registry, fmt};

/// The filter of logged events.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LogFilter(Targets);

/// A reason why a text is no filter.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FilterError {
    /// A part of it names no level.
    #[error("must be off, error, warn, info, debug or trace, or a list such as warn,baudbot_server=info")]
    Level,
    /// The library does not take it.
    #[error(transparent)]
    Target(#[from] tracing_subscriber::filter::ParseError),
}

impl FromStr for LogFilter {
    type Err = FilterError;

    fn from_str(text: &str) -> Result<Self, FilterError> {
        // A word without a level would be the name of a part of the program, and a slip of the pen pass for one.
        for part in text.split(',') {
            let level = part.rsplit_once('=').map_or(part, |(_, level)| level);
            if level.is_empty() || level.parse::<LevelFilter>().is_err() {
                return Err(FilterError::Level);
            }
        }
        Ok(Self(text.parse()?))
    }
}

/// The format of logged events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LogFormat {
    /// A line of text for each event
    Text,
    /// A JSON object on a line for each event
    Json,
}

/// The work that is left for the log at the end of the program.
pub(crate) struct Logs {
    /// Its contents are sent when it is dropped.
    #[cfg(feature = "otel")]
    _export: Option<otel::Export>,
}

/// A part of what hears events.
pub(crate) type Listener = Box<dyn Layer<Registry> + Send + Sync>;

/// Begins to log. A program that `serves` worlds also exports, if a collector is named.
pub(crate) fn start(LogFilter(filter): LogFilter, format: LogFormat, serves: bool) -> Logs {
    // Strangers can cause the warnings of h2 as often as they like: only a filter that wants all has them.
    let least = if tells_all(&filter, "h2") { LevelFilter::TRACE } else { LevelFilter::ERROR };
    let strangers =
        filter_fn(move |metadata| !metadata.target().starts_with("h2") || *metadata.level() <= least);
    // Without spans, which are for collectors: an event says all itself.
    let filter = filter.and(strangers).and(filter_fn(|metadata| metadata.is_event()));
    let stderr = match format {
        LogFormat::Text => {
            let text = fmt::layer().with_ansi(io::stderr().is_terminal()).with_writer(io::stderr);
            text.fmt_fields(PrintableFields).with_filter(filter).boxed()
        }
        LogFormat::Json => {
            let json = fmt::layer().with_writer(|| EscapedJson(io::stderr())).json();
            let json = json.flatten_event(true).with_current_span(false).with_span_list(false);
            json.with_filter(filter).boxed()
        }
    };
    let mut listeners: Vec<Listener> = vec![stderr];
    let logs = export(serves && has_collector(), &mut listeners);
    tracing_subscriber::registry().with(listeners).init();
    logs
}

/// Whether this program exports what it does.
pub(crate) fn exports() -> bool {
    cfg!(feature = "otel") && has_collector()
}

/// Whether a collector is named.
fn has_collector() -> bool {
    std::env::var_os(ENDPOINT).is_some_and(|to| !to.is_empty())
}

/// Whether what a part of the program says is told down to its details.
fn tells_all(filter: &Targets, part: &str) -> bool {
    LevelFilter::DEBUG.into_level().is_some_and(|debug| filter.would_enable(part, &debug))
}

/// Writes what an event says so that no terminal obeys it: names in it may be those of other users.
struct PrintableFields;

impl<'w> FormatFields<'w> for PrintableFields {
    fn format_fields<R: RecordFields>(&self, mut out: Writer<'w>, fields: R) -> std::fmt::Result {
        let mut text = String::new();
        DefaultFields::new().format_fields(Writer::new(&mut text), fields)?;
        write!(out, "{}", Printable(text))
    }
}

/// The same for lines of JSON, each of which comes at once.
struct EscapedJson<W>(W);

impl<W: Write> Write for EscapedJson<W> {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        self.0.write_all(text::escaped_json(&String::from_utf8_lossy(line)).as_bytes())?;
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

#[cfg(feature = "otel")]
fn export(asked: bool, listeners: &mut Vec<Listener>) -> Logs {
    let export = asked.then(|| otel::Export::start(listeners));
    let _export = export.and_then(|export| {
        export.map_err(|error| tell!("note: {ENDPOINT}: {error}; nothing is exported")).ok()
    });
    Logs { _export }
}

#[cfg(not(feature = "otel"))]
fn export(asked: bool, _: &mut [Listener]) -> Logs {
    if asked {
        tell!(
            "note: {ENDPOINT} is set, but this program was built without the feature otel: nothing is exported"
        );
    }
    Logs {}
}

/// The variable that names a collector, as in all programs that export.
pub(crate) const ENDPOINT: &str = "OTEL_EXPORTER_OTLP_ENDPOINT";

#[cfg(test)]
mod tests {
    use super::*;

    /// The lines that a log keeps in memory.
    #[derive(Clone, Default)]
    struct Kept(std::sync::Arc<std::sync::Mutex<Vec<u8>>>);

    impl Write for Kept {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn no_log_has_anything_that_a_terminal_obeys() {
        let (text, json) = (Kept::default(), Kept::default());
        let (to_text, to_json) = (text.clone(), json.clone());
        let as_text =
            fmt::layer().with_ansi(false).with_writer(move || to_text.clone()).fmt_fields(PrintableFields);
        let as_json = fmt::layer().with_writer(move || EscapedJson(to_json.clone())).json();
        let hostile = "\u{1b}[2J\u{9b}31m\u{202e}\n\r";
        tracing::subscriber::with_default(Registry::default().with(as_text).with(as_json), || {
            tracing::warn!(brain = hostile, world = %hostile, seat = ?hostile, "attached {hostile}");
        });
        for log in [text, json] {
            let log = String::from_utf8(log.0.lock().unwrap().clone()).unwrap();
            let (line, rest) = log.split_once('\n').unwrap();
            assert!(rest.is_empty() && line.chars().all(baudbot_fields::printable::is_printable), "{log:?}");
            assert!(line.contains("attached"), "{log:?}");
        }
    }

    #[test]
    fn filters_are_levels_of_all_or_of_parts() {
        for good in ["off", "warn", "INFO", "warn,baudbot_server=debug", "baudbot_server::actor=trace"] {
            assert!(good.parse::<LogFilter>().is_ok(), "{good}");
        }
        for bad in ["", "loud", "warn,", "baudbot_server", "baudbot_server=loud", "baudbot_server="] {
            assert!(bad.parse::<LogFilter>().is_err(), "{bad}");
        }
    }
}

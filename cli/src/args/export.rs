//! The arguments of `baudbot export`.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::chips::ChipOutput;
use super::value::{ValueError, finite, whole};

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// A recording: an MCAP file made by this program. Without an output option, its summary is printed
    pub(crate) file: PathBuf,
    /// Write the table that `baudbot run --csv` writes; `-` is stdout, here as for all outputs
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// Write that table as Parquet
    #[arg(long, value_name = "FILE")]
    pub(crate) parquet: Option<PathBuf>,
    /// Write the events of robots, cables and brains as a trace for ui.perfetto.dev
    #[arg(long, value_name = "FILE")]
    pub(crate) timeline: Option<PathBuf>,
    /// Write the same events as a CSV table, with collisions, brains and manual changes
    #[arg(long, value_name = "FILE")]
    pub(crate) events: Option<PathBuf>,
    /// Write a ROS 2 bag into this folder, which must not exist yet: scans, odometry, inertial measurements, commands, frames, the clock
    #[arg(long, value_name = "DIR")]
    pub(crate) rosbag2: Option<PathBuf>,
    /// Draw the arena from above with the robots' paths
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Write the beliefs of brains as a CSV table: state, pose, and each process's utility and whether it was active
    #[arg(long, value_name = "FILE")]
    pub(crate) beliefs_csv: Option<PathBuf>,
    /// Draw utilities and active processes over time
    #[arg(long, value_name = "FILE")]
    pub(crate) utilities_svg: Option<PathBuf>,
    /// With --utilities-svg, draw this column of --csv above them, such as a sensor's readings; may be given several times
    #[arg(long = "with", value_name = "COLUMN", requires = "utilities_svg")]
    pub(crate) with: Vec<String>,
    /// Draw the path of each brain's motivational state in the plane of two variables, with lethal boundaries and isoclines
    #[arg(long, value_name = "FILE")]
    pub(crate) space_svg: Option<PathBuf>,
    /// With --space-svg, the variables of the two axes [default: the first two, those with a lethal boundary before others]
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', requires = "space_svg")]
    pub(crate) axes: Vec<String>,
    /// Make a film of the page's arena as GIF; needs a browser
    #[arg(long, value_name = "FILE")]
    pub(crate) gif: Option<PathBuf>,
    /// Make a film of the page's arena as WebM; needs a browser
    #[arg(long, value_name = "FILE")]
    pub(crate) webm: Option<PathBuf>,
    /// Write the signals on the pins of a robot's chip as a VCD file, for GTKWave; may be given several times
    #[arg(long, value_name = "ROBOT=FILE", value_parser = super::chips::output)]
    pub(crate) vcd: Vec<ChipOutput>,
    /// Write the bytes that a robot's firmware sent to the laptop; may be given several times
    #[arg(long, value_name = "ROBOT=FILE", value_parser = super::chips::output)]
    pub(crate) serial: Vec<ChipOutput>,
    #[command(flatten)]
    pub(crate) window: WindowArgs,
    #[command(flatten)]
    pub(crate) rows: RowArgs,
    #[command(flatten)]
    pub(crate) film: FilmArgs,
    /// Write the summary as one JSON object
    #[arg(long, conflicts_with_all = OUTPUTS)]
    pub(crate) json: bool,
    /// Suppress the progress bar and notes
    #[arg(long)]
    pub(crate) quiet: bool,
}

/// Which part of the run.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct WindowArgs {
    /// Begin at this simulated time [default: where the recording begins]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = super::instant)]
    pub(crate) from_s: Option<f64>,
    /// End at this simulated time [default: where the recording ends]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = super::instant)]
    pub(crate) to_s: Option<f64>,
}

/// Which rows the tables have.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct RowArgs {
    /// Write only every N-th tick to --csv, --parquet and those topics of --rosbag2 that have a message per tick
    #[arg(long, value_name = "N", conflicts_with = "hz", value_parser = whole(1_u64..=u64::MAX))]
    pub(crate) every: Option<u64>,
    /// Write about this many ticks per simulated second to --csv, --parquet and --rosbag2, at a fixed interval of whole ticks
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, value_parser = positive)]
    pub(crate) hz: Option<f64>,
}

/// How films are.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct FilmArgs {
    /// Frames per second of film
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = whole(1_u32..=50))]
    pub(crate) fps: u32,
    /// Simulated seconds per second of film
    #[arg(long, value_name = "X", default_value_t = 1.0, allow_negative_numbers = true, value_parser = positive)]
    pub(crate) speed: f64,
    /// Width of a film, in pixels
    #[arg(long, value_name = "N", default_value_t = 800, value_parser = whole(160_u32..=3840))]
    pub(crate) width_px: u32,
    /// Colours of a film
    #[arg(long, value_name = "THEME", default_value = "light")]
    pub(crate) theme: Theme,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Theme {
    /// A light background, for bright rooms and paper
    Light,
    /// A dark background
    Dark,
}

impl ExportArgs {
    /// All outputs, each with its option.
    pub(crate) fn outputs(&self) -> impl Iterator<Item = (&'static str, &Path)> {
        let all = [
            ("--csv", &self.csv),
            ("--parquet", &self.parquet),
            ("--timeline", &self.timeline),
            ("--events", &self.events),
            ("--rosbag2", &self.rosbag2),
            ("--svg", &self.svg),
            ("--beliefs-csv", &self.beliefs_csv),
            ("--utilities-svg", &self.utilities_svg),
            ("--space-svg", &self.space_svg),
            ("--gif", &self.gif),
            ("--webm", &self.webm),
        ];
        let vcd = self.vcd.iter().map(|output| ("--vcd", output.file.as_path()));
        let serial = self.serial.iter().map(|output| ("--serial", output.file.as_path()));
        all.into_iter().filter_map(|(option, path)| Some((option, path.as_deref()?))).chain(vcd).chain(serial)
    }
}

/// The outputs that are not written beside a summary.
const OUTPUTS: [&str; 13] = [
    "csv",
    "parquet",
    "timeline",
    "events",
    "rosbag2",
    "svg",
    "beliefs_csv",
    "utilities_svg",
    "space_svg",
    "gif",
    "webm",
    "vcd",
    "serial",
];

fn positive(text: &str) -> Result<f64, ValueError> {
    let error = || ValueError::Text { form: "a positive number", text: text.to_owned() };
    finite(text).ok().filter(|number| *number > 0.0).ok_or_else(error)
}

pub(super) const EXAMPLES: &str = "\
Examples:
  baudbot export run.mcap                        a summary
  baudbot export run.mcap --csv run.csv --svg run.svg
  baudbot export run.mcap --parquet run.parquet --hz 10
  baudbot export run.mcap --timeline run.pftrace --from-s 12 --to-s 14
  baudbot export run.mcap --rosbag2 bag --hz 50
  baudbot export run.mcap --events - --quiet | grep collision
  baudbot export run.mcap --utilities-svg utilities.svg --with gauge.charge
  baudbot export run.mcap --space-svg space.svg --axes hunger,thirst
  baudbot export run.mcap --gif run.gif --speed 4
  baudbot export run.mcap --vcd robot=pins.vcd --from-s 2 --to-s 3
  baudbot export run.mcap --serial robot=-

The run is simulated again from the recorded inputs. If the replay differs from the recorded run, a warning gives the
first difference. Films are made by a headless browser: the one named by BAUDBOT_BROWSER, or else chromium,
chromium-browser, google-chrome or chrome.";

//! `baudbot watch`: a world as it moves, in text.

use std::fmt::Write;
use std::io::IsTerminal;
use std::time::Duration;

use anyhow::{Context, bail};
use baudbot_client::Channel;
use baudbot_fields::printable::PrintableLines;
use baudbot_plot::quantity::NOTHING;
use baudbot_proto::v1;
use serde_json::{Value, json};
use tonic::Streaming;

use crate::args::WatchArgs;
use crate::error::from_server;
use crate::map::Map;
use crate::signals::Stop;
use crate::text::{table, tell};
use crate::{connect, foxglove, natural, text};

pub(crate) async fn watch(args: &WatchArgs) -> anyhow::Result<()> {
    let mut stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    if let Some(at) = &args.foxglove {
        return tokio::select! {
            gone = foxglove::pass_on(&args.server, at) => gone,
            () = stop.wait() => Ok(()),
        };
    }
    let in_place = std::io::stdout().is_terminal() && !args.once && !args.json;
    let shown = tokio::select! {
        shown = show(args, in_place) => shown,
        () = stop.wait() => Ok(()),
    };
    if in_place {
        text::control(SHOW_CURSOR)?;
    }
    shown
}

async fn show(args: &WatchArgs, in_place: bool) -> anyhow::Result<()> {
    let channel = connect::channel(&args.server).await?;
    let world = connect::world(channel.clone(), &args.server).await?.world;
    let mut observe = connect::observe(channel.clone());
    let described = observe.describe_world(v1::DescribeWorldRequest { world: world.clone() }).await;
    let described = described.map_err(|status| from_server(&status))?.into_inner();
    let frames = observe.watch(v1::WatchRequest { world: world.clone(), ..Default::default() }).await;
    let mut frames = frames.map_err(|status| from_server(&status))?.into_inner();
    let size = if in_place { terminal() } else { PAPER };
    let mut view = View { world, described, map: None, size, collisions: Vec::new() };
    if in_place {
        text::control(CLEAR_AND_HIDE_CURSOR)?;
    }
    loop {
        let frame = next(&mut frames, &channel, &view.world, args.once).await?;
        let Some(frame) = frame else { bail!("the server closed the connection") };
        if args.json {
            text::print_json_line(&view.json(&frame))?;
        } else if in_place {
            text::control(&in_place_of_the_last(&PrintableLines(view.draw(&frame)).to_string()))?;
        } else {
            text::print(&format!("{}\n", view.draw(&frame)))?;
        }
        if args.once {
            return Ok(());
        }
    }
}

/// The next frame. A world that stands still gives none; then the reason is printed, and `once` is an error.
async fn next(
    frames: &mut Streaming<v1::WatchResponse>,
    channel: &Channel,
    world: &str,
    once: bool,
) -> anyhow::Result<Option<v1::WatchResponse>> {
    let mut told = false;
    loop {
        match tokio::time::timeout(STILL, frames.message()).await {
            Ok(frame) => return frame.map_err(|status| from_server(&status)),
            Err(_) => {
                let request = v1::GetWorldRequest { world: world.to_owned() };
                let answer = connect::control(channel.clone()).get_world(request).await;
                let status = answer.map_err(|status| from_server(&status))?.into_inner().status;
                let Some(why) = standstill(&status.unwrap_or_default()) else { continue };
                if once {
                    bail!("there is nothing to see: world `{world}` {why}");
                }
                if !std::mem::replace(&mut told, true) {
                    tell!("world {world} {why}");
                }
            }
        }
    }
}

/// The reason why a world stands still, if it does.
fn standstill(status: &v1::WorldStatus) -> Option<String> {
    match status.state() {
        v1::WorldState::WaitingForBrains => {
            let empty = status.robots.iter().filter(|robot| !robot.attached);
            let empty = natural::sorted(empty.map(|robot| robot.robot.as_str()), |name| name);
            Some(format!("waits for brains for: {}", empty.join(", ")))
        }
        v1::WorldState::Paused => Some("is paused".to_owned()),
        v1::WorldState::Ended => Some(format!("has ended because {}", status.ending)),
        v1::WorldState::Running | v1::WorldState::Unspecified => None,
    }
}

fn terminal() -> (usize, usize) {
    let (rows, columns) = console::Term::stdout().size();
    (rows.into(), columns.into())
}

struct View {
    world: String,
    described: v1::DescribeWorldResponse,
    map: Option<Map>,
    /// Rows and columns that a frame may take.
    size: (usize, usize),
    /// The last collisions.
    collisions: Vec<String>,
}

impl View {
    fn draw(&mut self, frame: &v1::WatchResponse) -> String {
        let time_s = frame.time_ns as f64 / 1e9;
        let mut text = format!("world {}  t = {time_s:.3} s  tick {}\n", self.world, frame.tick);
        let mut numbers = table("", &self.poses(frame));
        for (robot, truth) in self.robots(frame) {
            numbers += &samples(robot, truth, self.size.1);
        }
        let rows = self.size.0.saturating_sub(numbers.lines().count() + OTHER_LINES);
        let map = self.map.get_or_insert_with(|| Map::new(&self.described, &frame.robots, rows, self.size.1));
        text += &map.with_frame(&self.described, frame);
        text += &numbers;
        let hits = frame.collisions.iter();
        self.collisions.extend(hits.map(|c| format!("{time_s:.3} s: {} ran into {}", c.robot, c.with)));
        self.collisions.drain(..self.collisions.len().saturating_sub(COLLISIONS));
        for collision in &self.collisions {
            let _ = writeln!(text, "{collision}");
        }
        if !frame.ending.is_empty() {
            let _ = writeln!(text, "the run has ended: {}", frame.ending);
        }
        text
    }

    /// The frame for programs. What a sensor has not measured yet is null.
    fn json(&self, frame: &v1::WatchResponse) -> Value {
        let robots = self.robots(frame).into_iter().map(|(robot, truth)| {
            let samples = robot.sensor_columns.iter().zip(&truth.samples);
            let samples: serde_json::Map<_, _> =
                samples.map(|(column, number)| (column.clone(), json!(number))).collect();
            json!({
                "robot": robot.robot,
                "x_m": truth.x_m,
                "y_m": truth.y_m,
                "heading_rad": truth.heading_rad,
                "speed_m_s": truth.speed_m_s,
                "turn_rate_rad_s": truth.turn_rate_rad_s,
                "left_signal": truth.left_signal,
                "right_signal": truth.right_signal,
                "samples": samples,
            })
        });
        let collisions = frame.collisions.iter().map(|c| json!({ "robot": c.robot, "with": c.with }));
        json!({
            "world": self.world,
            "tick": frame.tick,
            "time_s": frame.time_ns as f64 / 1e9,
            "robots": robots.collect::<Vec<_>>(),
            "collisions": collisions.collect::<Vec<_>>(),
            "ending": (!frame.ending.is_empty()).then_some(&frame.ending),
        })
    }

    fn robots<'a>(
        &'a self,
        frame: &'a v1::WatchResponse,
    ) -> Vec<(&'a v1::ObservedRobot, &'a v1::RobotTruth)> {
        natural::sorted(self.described.robots.iter().zip(&frame.robots), |(robot, _)| &robot.robot)
    }

    fn poses(&self, frame: &v1::WatchResponse) -> Vec<[String; 8]> {
        let head =
            ["robot", "x (m)", "y (m)", "heading (rad)", "speed (m/s)", "turn (rad/s)", "left", "right"];
        let mut rows = vec![head.map(str::to_owned)];
        for (robot, truth) in self.robots(frame) {
            let motion = [truth.x_m, truth.y_m, truth.heading_rad, truth.speed_m_s, truth.turn_rate_rad_s];
            let [x, y, heading, speed, turn] = motion.map(|number| format!("{number:.3}"));
            let [left, right] = [truth.left_signal, truth.right_signal].map(|number| format!("{number:+.2}"));
            rows.push([robot.robot.clone(), x, y, heading, speed, turn, left, right]);
        }
        rows
    }
}

/// A robot's sensors in lines of at most `columns` characters.
fn samples(robot: &v1::ObservedRobot, truth: &v1::RobotTruth, columns: usize) -> String {
    let mut text = String::new();
    let mut line = format!("{}:", robot.robot);
    for (column, &number) in robot.sensor_columns.iter().zip(&truth.samples) {
        if is_one_of_many(column) {
            continue;
        }
        let value = if number.is_nan() { NOTHING.to_owned() } else { format!("{number:.3}") };
        let entry = format!("  {column} {value}");
        if line.chars().count() + entry.chars().count() > columns {
            let _ = writeln!(text, "{line}");
            line = " ".repeat(robot.robot.len() + 1);
        }
        line += &entry;
    }
    format!("{text}{line}\n")
}

/// Whether it is a later value of a component of many: a scan would fill the screen.
fn is_one_of_many(column: &str) -> bool {
    let last = column.rsplit_once('.').and_then(|(_, last)| last.parse::<usize>().ok());
    last.is_some_and(|place| place > 0)
}

/// The text written from the top of the screen, each line's rest erased, and what is below.
fn in_place_of_the_last(text: &str) -> String {
    format!("\x1b[H{}\x1b[J", text.replace('\n', "\x1b[K\n"))
}

const CLEAR_AND_HIDE_CURSOR: &str = "\x1b[2J\x1b[?25l";
const SHOW_CURSOR: &str = "\x1b[?25h";

/// The time without a frame after which it is asked whether the world stands still.
const STILL: Duration = Duration::from_secs(1);

/// Collisions on the screen.
const COLLISIONS: usize = 3;

/// Lines that are neither map nor numbers: the first, collisions, the ending, and the cursor's.
const OTHER_LINES: usize = COLLISIONS + 3;

/// Rows and columns of a frame that is no screen.
const PAPER: (usize, usize) = (40, 80);

//! `--rosbag2`: a bag of ROS 2, as `ros2 bag play` and its tools read it: a folder with an MCAP file and `metadata.yaml`.
//!
//! | topic | message | when |
//! |---|---|---|
//! | `/clock` | `rosgraph_msgs/Clock` | each tick |
//! | `/tf` | `tf2_msgs/TFMessage` | each tick: `map` → `odom` → `base_link`, the product of which is the truth |
//! | `/tf_static` | `tf2_msgs/TFMessage` | once: `base_link` → the frames of lasers, sonars and IR sensors |
//! | `/scan` | `sensor_msgs/LaserScan` | each scan of a laser that is fixed to the body |
//! | `/NAME/range` | `sensor_msgs/Range` | each reading of a sonar or an IR sensor that is fixed to the body |
//! | `/odom` | `nav_msgs/Odometry` | each reading of the odometer |
//! | `/ground_truth` | `nav_msgs/Odometry` | each tick: the true pose and speeds |
//! | `/imu` | `sensor_msgs/Imu` | each reading of a compass, gyroscope or accelerometer, with the last of the others |
//! | `/cmd_vel` | `geometry_msgs/Twist` | each change of what the motors are told, if that is speeds |
//!
//! With several robots, topics and frames of each begin with its name. Readings are those that the sensor took, at the instants at which it
//! took them, and not those that came through the cable: a bag has what a robot with ROS on board would have recorded.

mod cdr;
mod covariance;
mod messages;
mod metadata;
mod qos;
mod ranger;
mod robot;

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use baudbot_recording::PROGRAM_VERSION;
use baudbot_sim::World;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};

use super::pass::Sink;
use crate::error::Refused;
use messages::Kind;
use metadata::Topic;
use qos::Durability;
use robot::Robot;
pub(super) use robot::check_names;
pub(crate) use robot::ends_meet;

/// A bag that is being written.
pub(super) struct Bag {
    folder: PathBuf,
    /// The name of its file.
    file: String,
    mcap: mcap::Writer<BufWriter<File>>,
    channels: BTreeMap<String, (u16, Topic)>,
    robots: Vec<Robot>,
    /// Ticks between two of what is written with ticks.
    every: u64,
    /// The first instant and the last.
    span: Option<(u64, u64)>,
}

impl Bag {
    /// Makes the folder, which must not be there yet.
    ///
    /// # Errors
    /// If it is there, or cannot be made.
    pub(super) fn create(folder: &Path, world: &World, every: u64) -> anyhow::Result<Self> {
        let refused =
            |why: &dyn std::fmt::Display| Refused::error(format!("--rosbag2 {}: {why}", folder.display()));
        fs::create_dir(folder).map_err(|error| {
            if error.kind() == io::ErrorKind::AlreadyExists {
                refused(&"is there already; choose another folder, or remove it")
            } else if error.kind() == io::ErrorKind::NotFound {
                refused(&"its parent folder does not exist; create it with mkdir -p")
            } else {
                refused(&error)
            }
        })?;
        let name = fs::canonicalize(folder)?;
        let file = format!("{}_0.mcap", name.file_name().unwrap_or_default().to_string_lossy());
        let out = BufWriter::new(File::create_new(folder.join(&file)).map_err(|error| refused(&error))?);
        let options = WriteOptions::new()
            .profile("ros2")
            .compression(Some(Compression::Lz4))
            .library(format!("baudbot {PROGRAM_VERSION}"));
        let mcap = options.create(out).map_err(|error| refused(&error))?;
        let has_others = world.robots().len() > 1;
        let robots = world.robots().map(|robot| Robot::of(robot.spec(), has_others, world.scenario().noise));
        let robots = robots.collect();
        Ok(Self {
            folder: folder.to_owned(),
            file,
            mcap,
            channels: BTreeMap::new(),
            robots,
            every,
            span: None,
        })
    }

    fn write(&mut self, topic: &str, kind: &Kind, at_ns: u64, message: &[u8]) -> mcap::McapResult<()> {
        if !self.channels.contains_key(topic) {
            let parts = kind.definition.iter().map(|part| part.trim_end());
            let text = parts
                .collect::<Vec<_>>()
                .join("\n================================================================================\n");
            let schema = self.mcap.add_schema(kind.name, "ros2msg", text.as_bytes())?;
            let offered = qos::profile(Durability::of(topic));
            let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), offered)]);
            let channel = self.mcap.add_channel(schema, topic, "cdr", &metadata)?;
            let told = Topic { name: topic.to_owned(), kind: kind.name, messages: 0 };
            self.channels.insert(topic.to_owned(), (channel, told));
        }
        let Some((channel, told)) = self.channels.get_mut(topic) else { return Ok(()) };
        told.messages += 1;
        let sequence = u32::try_from(told.messages).unwrap_or(u32::MAX);
        let header = MessageHeader { channel_id: *channel, sequence, log_time: at_ns, publish_time: at_ns };
        self.mcap.write_to_known_channel(&header, message)
    }

    fn write_tick(&mut self, world: &World) -> mcap::McapResult<()> {
        let now_ns = world.time().as_ns();
        let is_first = self.span.is_none();
        self.span = Some((self.span.map_or(now_ns, |(from_ns, _)| from_ns), now_ns));
        let is_due = world.tick().is_multiple_of(self.every);
        if is_due {
            self.write("/clock", &messages::CLOCK, now_ns, &messages::clock(now_ns))?;
        }
        for i in 0..self.robots.len() {
            let robot = &mut self.robots[i];
            let said = robot.say(&world.robot(i), now_ns, (is_first, is_due));
            for (topic, kind, message) in said {
                self.write(&topic, kind, now_ns, &message)?;
            }
        }
        Ok(())
    }
}

impl Sink for Bag {
    fn tick(&mut self, world: &World) -> io::Result<()> {
        self.write_tick(world).map_err(io::Error::other)
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.mcap.finish().map_err(io::Error::other)?;
        let topics: Vec<_> =
            std::mem::take(&mut self.channels).into_values().map(|(_, topic)| topic).collect();
        let text = metadata::text(&self.file, &topics, self.span.unwrap_or_default());
        let mut out = File::create_new(self.folder.join("metadata.yaml"))?;
        out.write_all(text.as_bytes())
    }
}

//! The observable world as messages of [Foxglove](https://foxglove.dev): it opens a recording without conversion.
//!
//! | topic | message | what |
//! |---|---|---|
//! | `/scene/arena` | `SceneUpdate` | walls, discs, zones, lamps; once |
//! | `/scene/robots` | `SceneUpdate` | bodies in the frames `robot/NAME`; once |
//! | `/scene/things` | `SceneUpdate` | what moves by itself and what is pushed, in the frames `thing/NAME`; once |
//! | `/scene/odometry` | `SceneUpdate` | outlines in the frames `odometry/NAME`, of robots whose odometry is known |
//! | `/scene/rays` | `SceneUpdate` | what sensors look along, of robots with details |
//! | `/tf_static` | `FrameTransforms` | sensors that no turret turns, `robot/NAME/SENSOR`; once |
//! | `/tf` | `FrameTransforms` | all other frames |
//! | `/scan/ROBOT/SENSOR` | `LaserScan` | scans that have reached the brain, of robots with details |
//! | `/belief/ROBOT` | `SceneUpdate` | what its brain has published |
//! | `/belief/ROBOT/map` | `Grid` | the map in that |
//! | `/log` | `Log` | what happened |
//!
//! After a jump to another time Foxglove shows the last message of each topic, and no other: so each topic's last message is
//! complete. All times are simulated ones.

mod arena;
mod belief;
mod bodies;
mod event;
mod footprint;
mod frames;
mod map;
mod message;
mod odometry;
mod palette;
mod parts;
mod rays;
mod robot;
mod scan;
mod shape;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use baudbot_proto::v1;
use foxglove::messages::{FrameTransforms, SceneEntity, SceneUpdate};

use self::footprint::Heights;
use self::parts::time;
use self::robot::Robot;

pub use self::message::{FoxgloveMessage, MessageSchema};

/// Makes a world's messages, frame by frame; keeps of the world what it needs for that.
#[derive(Clone, Debug)]
pub struct FoxgloveEncoder {
    described: v1::DescribeWorldResponse,
    heights: Heights,
    robots: Vec<Robot>,
    /// Frames of things, in their order.
    things: Vec<String>,
    /// Names of the robots whose rays are shown.
    rays: Vec<String>,
    /// Places of the robots whose odometry is shown.
    ghosts: Vec<usize>,
    last_ns: u64,
    topics: Topics,
}

/// The topics that do not depend on the world.
#[derive(Clone, Debug)]
struct Topics {
    tf: Arc<str>,
    odometry: Arc<str>,
    rays: Arc<str>,
    log: Arc<str>,
}

impl Topics {
    fn new() -> Self {
        let [tf, odometry] = ["/tf", "/scene/odometry"].map(Arc::from);
        let [rays, log] = ["/scene/rays", "/log"].map(Arc::from);
        Self { tf, odometry, rays, log }
    }
}

impl FoxgloveEncoder {
    /// A `FoxgloveEncoder` of a world as it was described to its observers.
    pub fn new(described: &v1::DescribeWorldResponse) -> Self {
        let heights = Heights::new(described);
        Self {
            heights,
            robots: described.robots.iter().map(|robot| Robot::new(robot, &heights)).collect(),
            things: described.things.iter().map(|thing| frames::thing(&thing.thing)).collect(),
            described: described.clone(),
            rays: Vec::new(),
            ghosts: Vec::new(),
            last_ns: 0,
            topics: Topics::new(),
        }
    }

    /// Messages that are sent once, before the first frame: everything that stands still, shapes of bodies, and fixed frames.
    pub fn opening(&self, time_ns: u64) -> Vec<FoxgloveMessage> {
        let (described, heights) = (&self.described, &self.heights);
        let scenes = [
            ("/scene/arena", arena::arena(described, heights, time_ns)),
            ("/scene/robots", bodies::robots(described, heights, time_ns)),
            ("/scene/things", bodies::things(described, heights, time_ns)),
        ];
        let scenes = scenes.into_iter().filter(|(_, scene)| !scene.entities.is_empty());
        let mut messages: Vec<_> =
            scenes.map(|(topic, scene)| FoxgloveMessage::new(&topic.into(), time_ns, &scene)).collect();
        let fixed = frames::fixed(&described.robots, time_ns);
        if !fixed.transforms.is_empty() {
            messages.push(FoxgloveMessage::new(&"/tf_static".into(), time_ns, &fixed));
        }
        messages
    }

    /// A frame's messages: where everything is, and more about robots of which the frame has details.
    pub fn frame(&mut self, frame: &v1::WatchResponse) -> Vec<FoxgloveMessage> {
        if frame.time_ns < self.last_ns {
            self.robots.iter_mut().for_each(Robot::forget);
        }
        self.last_ns = frame.time_ns;
        for (robot, truth) in self.robots.iter_mut().zip(&frame.robots) {
            robot.note(truth, frame.time_ns);
        }
        let mut messages = Vec::new();
        for detail in &frame.details {
            if let Some(robot) = self.robots.get_mut(detail.robot as usize) {
                messages.extend(robot.take(detail, frame.time_ns));
            }
        }
        messages.extend(self.transforms(frame));
        messages.extend(self.ghosts(frame.time_ns));
        messages.extend(self.rays(frame));
        for annotation in &frame.annotations {
            let robot = self.robots.get_mut(annotation.robot as usize);
            if let (Some(robot), Some(belief)) = (robot, &annotation.belief) {
                messages.extend(robot.believer.messages(belief, frame.time_ns));
            }
        }
        messages
    }

    /// An event, in words.
    pub fn event(&self, time_ns: u64, kind: v1::ReplayEventKind, text: &str) -> FoxgloveMessage {
        event::event(&self.topics.log, time_ns, kind, text)
    }

    fn transforms(&self, frame: &v1::WatchResponse) -> Option<FoxgloveMessage> {
        let at = time(frame.time_ns);
        let robots = self.robots.iter().zip(&frame.robots).flat_map(|(robot, truth)| robot.frames(truth, at));
        let things = self.things.iter().zip(&frame.things).filter_map(|(child, thing)| {
            frames::in_world(at, child, [thing.x_m, thing.y_m, thing.heading_rad])
        });
        let transforms: Vec<_> = robots.chain(things).collect();
        let message = (!transforms.is_empty()).then_some(FrameTransforms { transforms });
        message.map(|message| FoxgloveMessage::new(&self.topics.tf, frame.time_ns, &message))
    }

    /// Each message is of all robots, and is sent when the set of those with one changes.
    fn ghosts(&mut self, time_ns: u64) -> Option<FoxgloveMessage> {
        let robots = self.robots.iter().enumerate();
        let begun: Vec<_> = robots.filter(|(_, robot)| robot.has_ghost()).map(|(place, _)| place).collect();
        if begun == self.ghosts {
            return None;
        }
        let described = begun.iter().map(|&place| &self.described.robots[place]);
        let scene = bodies::ghosts(described, &self.heights, time_ns);
        self.ghosts = begun;
        Some(FoxgloveMessage::new(&self.topics.odometry, time_ns, &scene))
    }

    /// Rays are replaced by name; when it is no longer those of the same robots, all of before go.
    fn rays(&mut self, frame: &v1::WatchResponse) -> Option<FoxgloveMessage> {
        let fans = frame
            .details
            .iter()
            .filter_map(|detail| self.robots.get(detail.robot as usize)?.rays(detail, frame.time_ns));
        let fans: Vec<SceneEntity> = fans.collect();
        let is_same = fans.iter().map(|fan| &fan.id).eq(&self.rays);
        if is_same && fans.is_empty() {
            return None;
        }
        let scene = if is_same {
            SceneUpdate { deletions: Vec::new(), entities: fans }
        } else {
            self.rays = fans.iter().map(|fan| fan.id.clone()).collect();
            parts::scene_anew(frame.time_ns, fans)
        };
        Some(FoxgloveMessage::new(&self.topics.rays, frame.time_ns, &scene))
    }
}

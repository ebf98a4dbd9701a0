//! The beliefs that a brain publishes, all in one colour: none of them need be true.

use std::sync::Arc;

use baudbot_proto::v1;
use baudbot_sim::Pose;
use foxglove::messages::line_primitive::Type as Line;
use foxglove::messages::{LinePrimitive, Point3, SceneEntity, SpherePrimitive};

use super::arena::label;
use super::bodies::reach;
use super::footprint::Footprint;
use super::frames;
use super::map;
use super::message::FoxgloveMessage;
use super::palette;
use super::parts::{WORLD, color, entity, fact, lines, part, point, pose_at, scene_anew, sound_pose, vector};

/// A robot whose brain may publish.
#[derive(Clone, Debug)]
pub(super) struct Believer {
    topic: Arc<str>,
    map_topic: Arc<str>,
    frame: String,
    shape: Footprint,
    /// Beliefs are drawn above all else.
    z_m: f64,
    /// A map has been shown.
    has_map: bool,
}

impl Believer {
    pub(super) fn new(robot: &v1::ObservedRobot, z_m: f64) -> Self {
        let name = part(&robot.robot);
        let disc = Footprint::Disc { center: [0.0; 2], radius_m: 0.1 };
        Self {
            topic: format!("/belief/{name}").into(),
            map_topic: format!("/belief/{name}/map").into(),
            frame: frames::robot(&robot.robot),
            shape: Footprint::of_robot(robot).unwrap_or(disc),
            z_m,
            has_map: false,
        }
    }

    /// The messages for a belief. It replaces all earlier ones; an empty belief takes all back.
    pub(super) fn messages(&mut self, belief: &v1::Belief, time_ns: u64) -> Vec<FoxgloveMessage> {
        let at = belief.pose.as_ref().and_then(|pose| sound_pose(pose.x_m, pose.y_m, pose.heading_rad));
        let parts = [
            self.state(belief, at, time_ns),
            self.pose(belief, at, time_ns),
            self.particles(belief, time_ns),
            self.path(belief, time_ns),
        ];
        let scene = scene_anew(time_ns, parts.into_iter().flatten().collect());
        let mut messages = vec![FoxgloveMessage::new(&self.topic, time_ns, &scene)];
        let map = belief.map.as_ref().and_then(|map| map::grid(map, time_ns));
        if map.is_some() || self.has_map {
            self.has_map = map.is_some();
            // A grid cannot be taken back.
            let grid = map.unwrap_or_else(|| map::nothing(time_ns));
            messages.push(FoxgloveMessage::new(&self.map_topic, time_ns, &grid));
        }
        messages
    }

    /// The brain's activity, in words; behind the believed pose, or behind the true one.
    fn state(&self, belief: &v1::Belief, at: Option<Pose>, time_ns: u64) -> Option<SceneEntity> {
        if at.is_none() && belief.state.is_empty() && belief.utilities.is_empty() {
            return None;
        }
        let frame = if at.is_some() { WORLD } else { self.frame.as_str() };
        let mut entity = entity(time_ns, frame, "state");
        let below_m = 2.4 * reach(&self.shape);
        let at = at.map_or([0.0, -below_m], |at| [at.position.x, at.position.y - below_m]);
        let words: String = belief.state.chars().take(40).collect();
        let text = if words.is_empty() { "belief".to_owned() } else { format!("belief: {words}") };
        let mut label = label(&text, at, self.z_m);
        label.color = Some(color(palette::BELIEF, 1.0));
        entity.texts.push(label);
        for utility in &belief.utilities {
            let key = format!("utility {}", utility.name);
            // Keys must be unique.
            if entity.metadata.iter().all(|known| known.key != key) {
                let running = if utility.active { ", running" } else { "" };
                entity.metadata.push(fact(&key, format!("{}{running}", utility.value)));
            }
        }
        Some(entity)
    }

    /// The robot's outline at the believed pose, and the area of its position with 95 %.
    fn pose(&self, belief: &v1::Belief, at: Option<Pose>, time_ns: u64) -> Option<SceneEntity> {
        let at = at?;
        let mut entity = entity(time_ns, WORLD, "pose");
        entity.lines.push(self.line(Line::LineLoop, self.shape.rim_at(&at, self.z_m), 1.0));
        let (sin, cos) = at.heading.sin_cos();
        let (x_m, y_m, ahead_m) = (at.position.x, at.position.y, 1.25 * reach(&self.shape));
        let ahead =
            vec![point(x_m, y_m, self.z_m), point(x_m + ahead_m * cos, y_m + ahead_m * sin, self.z_m)];
        entity.lines.push(self.line(Line::LineStrip, ahead, 1.0));
        if let Some(rim) = belief.pose.as_ref().and_then(|pose| ellipse(&pose.covariance_m2)) {
            let rim = rim.into_iter().map(|[dx, dy]| point(x_m + dx, y_m + dy, self.z_m)).collect();
            entity.lines.push(self.line(Line::LineLoop, rim, 0.7));
        }
        Some(entity)
    }

    /// A stroke each, the heavier the clearer.
    fn particles(&self, belief: &v1::Belief, time_ns: u64) -> Option<SceneEntity> {
        let heaviest = belief.particles.iter().map(|particle| particle.weight).fold(0.0, f32::max);
        let length_m = 0.5 * reach(&self.shape);
        let mut strokes = self.line(Line::LineList, Vec::new(), 1.0);
        for particle in &belief.particles {
            let (x_m, y_m) = (f64::from(particle.x_m), f64::from(particle.y_m));
            let Some(at) = sound_pose(x_m, y_m, f64::from(particle.heading_rad)) else { continue };
            let (sin, cos) = at.heading.sin_cos();
            strokes.points.push(point(x_m, y_m, self.z_m));
            strokes.points.push(point(x_m + length_m * cos, y_m + length_m * sin, self.z_m));
            let share =
                if heaviest > 0.0 { f64::from(particle.weight / heaviest).clamp(0.0, 1.0) } else { 1.0 };
            // A weight that is no number is as good as none.
            let share = if share.is_nan() { 0.0 } else { share };
            strokes.colors.extend([color(palette::BELIEF, 0.25 + 0.5 * share); 2]);
        }
        if strokes.points.is_empty() {
            return None;
        }
        let mut entity = entity(time_ns, WORLD, "particles");
        entity.lines.push(strokes);
        Some(entity)
    }

    fn path(&self, belief: &v1::Belief, time_ns: u64) -> Option<SceneEntity> {
        let sound = belief.path.iter().filter(|at| at.x_m.is_finite() && at.y_m.is_finite());
        let points: Vec<_> = sound.map(|at| point(at.x_m, at.y_m, self.z_m)).collect();
        let end = points.last().copied()?;
        let mut entity = entity(time_ns, WORLD, "path");
        if points.len() >= 2 {
            entity.lines.push(self.line(Line::LineStrip, points, 1.0));
        }
        let width_m = 0.4 * reach(&self.shape);
        entity.spheres.push(SpherePrimitive {
            pose: Some(pose_at(end.x, end.y, end.z)),
            size: Some(vector(width_m, width_m, width_m)),
            color: Some(color(palette::BELIEF, 1.0)),
        });
        Some(entity)
    }

    fn line(&self, kind: Line, points: Vec<Point3>, alpha: f64) -> LinePrimitive {
        lines(kind, points, 2.0, color(palette::BELIEF, alpha))
    }
}

/// About its middle: two standard deviations and a half, 2.45. None if the covariance is none.
fn ellipse(covariance_m2: &[f64]) -> Option<Vec<[f64; 2]>> {
    let &[xx, xy, yy] = covariance_m2 else { return None };
    let mean = 0.5 * (xx + yy);
    let spread = (0.5 * (xx - yy)).hypot(xy);
    if !(mean + spread).is_finite() {
        return None;
    }
    let [long_m, short_m] = [mean + spread, mean - spread].map(|variance| 2.45 * variance.max(0.0).sqrt());
    let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
    let turned = |[x, y]: [f64; 2]| {
        let (along, across) = (long_m * x, short_m * y);
        [cos * along - sin * across, sin * along + cos * across]
    };
    Some(super::shape::circle(1.0).into_iter().map(turned).collect())
}

#[cfg(test)]
mod tests {
    use foxglove::Decode as _;
    use foxglove::messages::{Grid, SceneUpdate, scene_entity_deletion};

    use super::*;

    fn believer() -> Believer {
        let robot =
            v1::ObservedRobot { robot: "alice".into(), radius_m: 0.1, ..v1::ObservedRobot::default() };
        Believer::new(&robot, 0.5)
    }

    fn scene(message: &FoxgloveMessage) -> SceneUpdate {
        SceneUpdate::decode(&message.data[..]).unwrap()
    }

    fn ids(scene: &SceneUpdate) -> Vec<&str> {
        scene.entities.iter().map(|entity| entity.id.as_str()).collect()
    }

    fn belief() -> v1::Belief {
        let utility = |value| v1::Utility { name: "flee".into(), value, active: true };
        let particle = |weight| v1::Particle { x_m: 1.0, y_m: 2.0, heading_rad: 0.0, weight };
        let at = |x_m, y_m| v1::Point { x_m, y_m };
        v1::Belief {
            state: "wander".into(),
            utilities: vec![utility(0.5), utility(0.7)],
            pose: Some(v1::BelievedPose {
                x_m: 1.0,
                y_m: 2.0,
                heading_rad: 0.0,
                covariance_m2: vec![0.04, 0.0, 0.01],
            }),
            particles: vec![particle(1.0), particle(0.5)],
            path: vec![at(0.0, 0.0), at(3.0, 4.0)],
            map: Some(v1::GridMap { cell_m: 0.1, columns: 1, cells: vec![254], ..v1::GridMap::default() }),
            motivation: None,
        }
    }

    #[test]
    fn a_belief_is_drawn_in_its_colour_and_stands_for_all_before() {
        let messages = believer().messages(&belief(), 3);
        assert_eq!(
            messages.iter().map(|message| &*message.topic).collect::<Vec<_>>(),
            ["/belief/alice", "/belief/alice/map"]
        );
        let scene = scene(&messages[0]);
        assert_eq!(scene.deletions[0].r#type(), scene_entity_deletion::Type::All);
        assert_eq!(ids(&scene), ["state", "pose", "particles", "path"]);
        let [state, pose, particles, path] = &scene.entities[..] else { unreachable!("four, as above") };
        assert_eq!(state.texts[0].text, "belief: wander");
        assert_eq!(state.metadata.len(), 1, "a key once");
        assert_eq!(
            (state.metadata[0].key.as_str(), state.metadata[0].value.as_str()),
            ("utility flee", "0.5, running")
        );
        let ellipse = &pose.lines[2].points;
        let reach_m = ellipse.iter().map(|p| p.x - 1.0).fold(0.0, f64::max);
        assert!((reach_m - 2.45 * 0.2).abs() < 1e-12, "{reach_m}");
        assert_eq!(particles.lines[0].points.len(), particles.lines[0].colors.len());
        let alphas: Vec<_> = particles.lines[0].colors.iter().map(|color| color.a).collect();
        assert_eq!(alphas, [0.75, 0.75, 0.5, 0.5]);
        assert_eq!(path.spheres[0].pose.unwrap().position.unwrap(), vector(3.0, 4.0, 0.5));
        assert_eq!(path.lines[0].color.unwrap(), color(palette::BELIEF, 1.0));
    }

    #[test]
    fn a_belief_that_is_taken_back_leaves_nothing() {
        let mut believer = believer();
        assert_eq!(believer.messages(&v1::Belief::default(), 0).len(), 1, "there was no map");
        believer.messages(&belief(), 1);
        let messages = believer.messages(&v1::Belief::default(), 2);
        let scene = scene(&messages[0]);
        assert!(scene.entities.is_empty() && scene.deletions.len() == 1);
        let grid = Grid::decode(&messages[1].data[..]).unwrap();
        assert_eq!(&grid.data[..], [0; 4], "nothing is to be seen of it");
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let mut nowhere = belief();
        nowhere.pose.as_mut().unwrap().x_m = f64::NAN;
        nowhere.particles[0].y_m = f32::INFINITY;
        nowhere.particles[1].weight = f32::NAN;
        nowhere.path[1].x_m = f64::NAN;
        let messages = believer().messages(&nowhere, 0);
        let scene = scene(&messages[0]);
        assert_eq!(ids(&scene), ["state", "particles", "path"]);
        assert_eq!(scene.entities[0].frame_id, "robot/alice", "at the robot itself");
        assert_eq!(scene.entities[1].lines[0].points.len(), 2);
        assert!(scene.entities[1].lines[0].colors.iter().all(|color| color.a.is_finite()));
        assert!(scene.entities[2].lines.is_empty(), "a path of one place is no line");
        assert_eq!(ellipse(&[1.0, f64::NAN, 1.0]), None);
        assert_eq!(ellipse(&[1.0]), None);
    }
}

//! The small pieces of Foxglove's messages, made of ours.

use baudbot_sim::Pose;
use foxglove::messages::scene_entity_deletion::Type as Deletion;
use foxglove::messages::{
    Color, KeyValuePair, LinePrimitive, Point3, Quaternion, SceneEntity, SceneEntityDeletion, SceneUpdate,
    Timestamp, Vector3, line_primitive,
};

/// The frame in which everything is.
pub(super) const WORLD: &str = "world";

/// A time that is beyond Foxglove's 136 years is its last.
pub(super) fn time(time_ns: u64) -> Timestamp {
    let (seconds, rest_ns) = (time_ns / SECOND_NS, time_ns % SECOND_NS);
    u32::try_from(seconds).map_or(Timestamp::MAX, |seconds| Timestamp::new(seconds, rest_ns as u32))
}

const SECOND_NS: u64 = 1_000_000_000;

/// A pose of ours, if all of it is a number.
pub(super) fn sound_pose(x_m: f64, y_m: f64, heading_rad: f64) -> Option<Pose> {
    [x_m, y_m, heading_rad].iter().all(|value| value.is_finite()).then(|| Pose::new(x_m, y_m, heading_rad))
}

/// A turn about the vertical axis.
pub(super) fn turn(heading_rad: f64) -> Quaternion {
    let (sin, cos) = (0.5 * heading_rad).sin_cos();
    Quaternion { x: 0.0, y: 0.0, z: sin, w: cos }
}

pub(super) fn pose(pose: &Pose, z_m: f64) -> foxglove::messages::Pose {
    let position = vector(pose.position.x, pose.position.y, z_m);
    foxglove::messages::Pose { position: Some(position), orientation: Some(turn(pose.heading)) }
}

pub(super) fn pose_at(x_m: f64, y_m: f64, z_m: f64) -> foxglove::messages::Pose {
    pose(&Pose::new(x_m, y_m, 0.0), z_m)
}

pub(super) fn vector(x: f64, y: f64, z: f64) -> Vector3 {
    Vector3 { x, y, z }
}

pub(super) fn point(x: f64, y: f64, z: f64) -> Point3 {
    Point3 { x, y, z }
}

pub(super) fn color([red, green, blue]: [u8; 3], alpha: f64) -> Color {
    let share = |level: u8| f64::from(level) / 255.0;
    Color { r: share(red), g: share(green), b: share(blue), a: alpha }
}

/// An entity that stays until another of its name, or a deletion, comes.
pub(super) fn entity(time_ns: u64, frame: &str, id: impl Into<String>) -> SceneEntity {
    SceneEntity {
        timestamp: Some(time(time_ns)),
        frame_id: frame.to_owned(),
        id: id.into(),
        frame_locked: true,
        ..SceneEntity::default()
    }
}

pub(super) fn scene(entities: Vec<SceneEntity>) -> SceneUpdate {
    SceneUpdate { deletions: Vec::new(), entities }
}

/// A scene that stands for all that its topic showed before.
pub(super) fn scene_anew(time_ns: u64, entities: Vec<SceneEntity>) -> SceneUpdate {
    let all = SceneEntityDeletion {
        timestamp: Some(time(time_ns)),
        r#type: Deletion::All.into(),
        id: String::new(),
    };
    SceneUpdate { deletions: vec![all], entities }
}

/// Lines that are as thick on the screen from near and from far.
pub(super) fn lines(
    kind: line_primitive::Type,
    points: Vec<Point3>,
    thickness_px: f64,
    color: Color,
) -> LinePrimitive {
    LinePrimitive {
        r#type: kind.into(),
        pose: Some(pose_at(0.0, 0.0, 0.0)),
        thickness: thickness_px,
        scale_invariant: true,
        points,
        color: Some(color),
        ..LinePrimitive::default()
    }
}

pub(super) fn fact(key: &str, value: impl ToString) -> KeyValuePair {
    KeyValuePair { key: key.to_owned(), value: value.to_string() }
}

/// A name as a part of a topic or a frame. Scenarios only have names of letters, digits, `_` and `-`, of which nothing
/// changes; a description from elsewhere cannot make a topic that is none.
pub(super) fn part(name: &str) -> String {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let part: String = name.chars().map(|c| if fits(c) { c } else { '_' }).collect();
    if part.is_empty() { "_".to_owned() } else { part }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn times_are_seconds_and_the_rest() {
        let at = time(3_000_000_007);
        assert_eq!((at.sec(), at.nsec()), (3, 7));
        assert_eq!(time(u64::MAX), Timestamp::MAX);
    }

    #[test]
    fn a_quarter_turn_takes_forwards_to_the_left() {
        let Quaternion { x, y, z, w } = turn(FRAC_PI_2);
        // The first column of the rotation matrix: where the x axis goes.
        let forwards = [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)];
        assert!(forwards[0].abs() < 1e-12 && (forwards[1] - 1.0).abs() < 1e-12, "{forwards:?}");
    }

    #[test]
    fn names_are_parts_of_topics_whatever_is_in_them() {
        assert_eq!(part("ir_front-2"), "ir_front-2");
        assert_eq!(part("a/b é"), "a_b__");
        assert_eq!(part(""), "_");
    }

    #[test]
    fn a_pose_without_a_number_is_none() {
        assert!(sound_pose(1.0, 2.0, 3.0).is_some());
        assert!(sound_pose(f64::NAN, 2.0, 3.0).is_none());
        assert!(sound_pose(1.0, 2.0, f64::INFINITY).is_none());
    }
}

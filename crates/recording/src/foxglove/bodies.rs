//! Robots and things in frames of their own. They are sent once; only their frames move.

use baudbot_proto::v1;
use foxglove::messages::line_primitive::Type as Line;
use foxglove::messages::{ArrowPrimitive, SceneEntity, SceneUpdate};

use super::arena::label;
use super::footprint::{Footprint, Heights};
use super::frames;
use super::palette;
use super::parts::{color, entity, lines, point, pose_at, scene, scene_anew};
use super::shape::raised;

/// Bodies of robots, with an arrow ahead and the name behind.
pub(super) fn robots(described: &v1::DescribeWorldResponse, heights: &Heights, time_ns: u64) -> SceneUpdate {
    scene(described.robots.iter().filter_map(|robot| body(robot, heights, time_ns)).collect())
}

fn body(robot: &v1::ObservedRobot, heights: &Heights, time_ns: u64) -> Option<SceneEntity> {
    let shape = Footprint::of_robot(robot)?;
    let (rgb, top_m) = (palette::own(robot.look.as_ref(), palette::ROBOT), heights.of_robot(robot));
    let mut entity = entity(time_ns, &frames::robot(&robot.robot), &robot.robot);
    shape.build(&mut entity, [0.0, top_m], color(rgb, 1.0));
    for part in &robot.parts {
        if let Some(shape) = part.outline.as_ref().and_then(Footprint::of_outline) {
            let paint = color(palette::own(part.look.as_ref(), palette::ROBOT), 1.0);
            shape.build(&mut entity, heights.of(part.look.as_ref()), paint);
        }
    }
    let reach_m = reach(&shape);
    entity.arrows.push(ArrowPrimitive {
        pose: Some(pose_at(0.0, 0.0, 1.01 * top_m)),
        shaft_length: 0.6 * reach_m,
        shaft_diameter: 0.15 * reach_m,
        head_length: 0.4 * reach_m,
        head_diameter: 0.4 * reach_m,
        color: Some(color(palette::on(rgb), 1.0)),
    });
    entity.texts.push(label(&robot.robot, [-1.6 * reach_m, 0.0], top_m));
    Some(entity)
}

/// The greatest distance of a body from its origin.
pub(super) fn reach(shape: &Footprint) -> f64 {
    shape.rim().iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max)
}

/// The things that move by themselves and those that are pushed.
pub(super) fn things(described: &v1::DescribeWorldResponse, heights: &Heights, time_ns: u64) -> SceneUpdate {
    let thing = |thing: &v1::ObservedThing| {
        let shape = Footprint::of_outline(thing.outline.as_ref()?)?;
        let otherwise = if thing.movable { palette::MOVABLE } else { palette::MOVER };
        let rgb = palette::own(thing.look.as_ref(), otherwise);
        let mut entity = entity(time_ns, &frames::thing(&thing.thing), &thing.thing);
        shape.build(&mut entity, heights.of(thing.look.as_ref()), color(rgb, 1.0));
        Some(entity)
    };
    scene(described.things.iter().filter_map(thing).collect())
}

/// Outlines of where robots would be by their odometry: of those that have begun.
pub(super) fn ghosts<'a>(
    robots: impl Iterator<Item = &'a v1::ObservedRobot>,
    heights: &Heights,
    time_ns: u64,
) -> SceneUpdate {
    let dead_reckoning = |robot: &v1::ObservedRobot| {
        let shape = Footprint::of_robot(robot)?;
        let (z_m, paint) = (heights.of_robot(robot), color(palette::GHOST, 1.0));
        let mut entity = entity(time_ns, &frames::odometry(&robot.robot), &robot.robot);
        entity.lines.push(lines(Line::LineLoop, raised(&shape.rim(), z_m), 1.5, paint));
        let ahead = vec![point(0.0, 0.0, z_m), point(reach(&shape), 0.0, z_m)];
        entity.lines.push(lines(Line::LineStrip, ahead, 1.5, paint));
        Some(entity)
    };
    scene_anew(time_ns, robots.filter_map(dead_reckoning).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_has_a_body_an_arrow_and_a_name_in_its_own_frame() {
        let described = v1::DescribeWorldResponse {
            robots: vec![
                v1::ObservedRobot { robot: "alice".into(), radius_m: 0.1, ..v1::ObservedRobot::default() },
                v1::ObservedRobot {
                    robot: "nobody".into(),
                    radius_m: f64::NAN,
                    ..v1::ObservedRobot::default()
                },
            ],
            ..v1::DescribeWorldResponse::default()
        };
        let scene = robots(&described, &Heights::new(&described), 2_000_000_000);
        assert_eq!(scene.entities.len(), 1);
        let alice = &scene.entities[0];
        assert_eq!((alice.id.as_str(), alice.frame_id.as_str()), ("alice", "robot/alice"));
        assert!(alice.frame_locked && alice.lifetime.is_none());
        assert_eq!(alice.timestamp.unwrap().sec(), 2);
        let size = alice.cylinders[0].size.unwrap();
        assert_eq!((size.x, size.z), (0.2, 0.1));
        let arrow = &alice.arrows[0];
        assert!((arrow.shaft_length + arrow.head_length - 0.1).abs() < 1e-12, "as far as the rim");
        assert_eq!(alice.texts[0].text, "alice");
    }

    #[test]
    fn things_have_the_colour_of_what_they_are() {
        let outline = Some(v1::Outline { radius_m: 0.2, ..v1::Outline::default() });
        let thing = |name: &str, movable| v1::ObservedThing {
            thing: name.into(),
            movable,
            outline: outline.clone(),
            look: None,
        };
        let described = v1::DescribeWorldResponse {
            things: vec![thing("door", false), thing("ball", true)],
            ..v1::DescribeWorldResponse::default()
        };
        let scene = things(&described, &Heights::new(&described), 0);
        let colors: Vec<_> = scene.entities.iter().map(|entity| entity.cylinders[0].color.unwrap()).collect();
        assert_eq!(colors, [color(palette::MOVER, 1.0), color(palette::MOVABLE, 1.0)]);
        assert_eq!(scene.entities[1].frame_id, "thing/ball");
    }
}

//! The rays of sensors, as thin lines: of all sensors that have rays, except those whose scans are shown.

use baudbot_proto::v1::{self, SensorKind};
use foxglove::messages::line_primitive::Type as Line;
use foxglove::messages::{LinePrimitive, SceneEntity};

use super::palette;
use super::parts::{WORLD, color, entity, lines, point, pose_at, sound_pose};

/// Rays that are drawn of one sensor; of one with more, some that are evenly chosen.
const MOST_RAYS: usize = 64;

/// The rays of a robot's sensors, with their kinds, under the robot's name, at a height at which they are seen. Frames
/// have many rays: those of a kind are in one list, and corners that they share are in it once.
pub(super) fn fans<'a>(
    robot: &str,
    sensors: impl Iterator<Item = (SensorKind, &'a v1::RayFan)>,
    (z_m, time_ns): (f64, u64),
) -> Option<SceneEntity> {
    let mut kinds: Vec<(SensorKind, LinePrimitive)> = Vec::new();
    for (kind, rays) in sensors {
        let place = kinds.iter().position(|(known, _)| *known == kind).unwrap_or_else(|| {
            let mut line = lines(Line::LineList, Vec::new(), 1.0, color(palette::sensor(kind), 0.6));
            line.pose = Some(pose_at(0.0, 0.0, z_m));
            kinds.push((kind, line));
            kinds.len() - 1
        });
        add(&mut kinds[place].1, rays);
    }
    let mut entity = entity(time_ns, WORLD, robot);
    entity.lines = kinds.into_iter().map(|(_, line)| line).filter(|line| !line.indices.is_empty()).collect();
    (!entity.lines.is_empty()).then_some(entity)
}

/// The rays of a sensor, from the first on the right to the last.
fn add(line: &mut LinePrimitive, rays: &v1::RayFan) {
    let Some(sensor) = sound_pose(rays.x_m, rays.y_m, rays.heading_rad) else { return };
    let count = rays.lengths_m.len();
    let bearing_rad = |k: usize| match count {
        0 | 1 => 0.0,
        _ => rays.opening_rad * (k as f64 / (count - 1) as f64 - 0.5),
    };
    let (x_m, y_m) = (sensor.position.x, sensor.position.y);
    let origin = line.points.len() as u32;
    line.points.push(point(x_m, y_m, 0.0));
    for k in chosen(count) {
        let (sin, cos) = (sensor.heading + bearing_rad(k)).sin_cos();
        let length_m = f64::from(rays.lengths_m[k]);
        let tip = [x_m + length_m * cos, y_m + length_m * sin];
        if tip.iter().all(|value| value.is_finite()) {
            line.indices.extend([origin, line.points.len() as u32]);
            line.points.push(point(tip[0], tip[1], 0.0));
        }
    }
}

/// All places, or so many with the first and the last among them.
fn chosen(count: usize) -> impl Iterator<Item = usize> {
    let shown = count.min(MOST_RAYS);
    (0..shown).map(move |i| if shown == count { i } else { i * (count - 1) / (shown - 1) })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    /// The ends of all lines.
    fn ends(line: &LinePrimitive) -> Vec<[[f64; 2]; 2]> {
        let corner = |i: u32| [line.points[i as usize].x, line.points[i as usize].y];
        line.indices.chunks_exact(2).map(|pair| [corner(pair[0]), corner(pair[1])]).collect()
    }

    #[test]
    fn rays_run_from_the_sensor_from_right_to_left() {
        let rays = v1::RayFan {
            x_m: 1.0,
            y_m: 2.0,
            heading_rad: FRAC_PI_2,
            opening_rad: std::f64::consts::PI,
            lengths_m: vec![1.0, 2.0, 3.0],
        };
        let fan = fans("alice", [(SensorKind::Ir, &rays)].into_iter(), (0.1, 7)).unwrap();
        assert_eq!((fan.frame_id.as_str(), fan.id.as_str()), ("world", "alice"));
        let line = &fan.lines[0];
        assert_eq!(line.r#type(), Line::LineList);
        assert_eq!(line.color.unwrap(), color([213, 94, 0], 0.6));
        assert_eq!(line.pose.unwrap().position.unwrap().z, 0.1);
        for ([from, tip], [x, y]) in ends(line).into_iter().zip([[2.0, 2.0], [1.0, 4.0], [-2.0, 2.0]]) {
            assert_eq!(from, [1.0, 2.0]);
            assert!((tip[0] - x).abs() < 1e-12 && (tip[1] - y).abs() < 1e-12, "{tip:?}, {x}, {y}");
        }
    }

    #[test]
    fn rays_of_a_kind_have_one_colour_and_those_of_each_sensor_their_own_origin() {
        let at = |x_m| v1::RayFan { x_m, lengths_m: vec![1.0], ..v1::RayFan::default() };
        let (a, b, c) = (at(0.0), at(10.0), at(20.0));
        let fan = fans(
            "alice",
            [(SensorKind::Ir, &a), (SensorKind::Sonar, &b), (SensorKind::Ir, &c)].into_iter(),
            (0.1, 7),
        )
        .unwrap();
        let shown: Vec<_> = fan.lines.iter().map(ends).collect();
        assert_eq!(
            shown,
            [vec![[[0.0, 0.0], [1.0, 0.0]], [[20.0, 0.0], [21.0, 0.0]]], vec![[[10.0, 0.0], [11.0, 0.0]]],]
        );
    }

    #[test]
    fn of_many_rays_the_first_the_last_and_some_between_are_drawn() {
        let some: Vec<_> = chosen(10_000).collect();
        assert_eq!((some.len(), some[0], some[63]), (MOST_RAYS, 0, 9999));
        assert!(some.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(chosen(3).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(chosen(0).count(), 0);
    }

    #[test]
    fn rays_to_nowhere_are_left_out() {
        let rays = v1::RayFan { lengths_m: vec![1.0, f32::NAN, f32::INFINITY], ..v1::RayFan::default() };
        let fan = |rays: &v1::RayFan| fans("alice", [(SensorKind::Ir, rays)].into_iter(), (0.0, 0));
        assert_eq!(ends(&fan(&rays).unwrap().lines[0]), [[[0.0, 0.0], [1.0, 0.0]]]);
        assert!(fan(&v1::RayFan::default()).is_none());
        assert!(fan(&v1::RayFan { x_m: f64::NAN, ..rays }).is_none());
    }
}

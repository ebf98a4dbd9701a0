//! Everything that stands still: walls, discs, zones, lamps. It is sent once.

use baudbot_plot::palette::{ZoneUses, rgb};
use baudbot_proto::v1;
use foxglove::messages::line_primitive::Type as Line;
use foxglove::messages::{SceneEntity, SceneUpdate, SpherePrimitive, TextPrimitive};

use super::footprint::{Footprint, Heights};
use super::palette;
use super::parts::{WORLD, color, entity, fact, lines, pose_at, scene, vector};
use super::shape::{corners, raised, sides};

/// All of it, each thing under a name of its own.
pub(super) fn arena(described: &v1::DescribeWorldResponse, heights: &Heights, time_ns: u64) -> SceneUpdate {
    let walls = described.polygons.iter().filter_map(|polygon| wall(polygon, heights, time_ns));
    let discs = described.circles.iter().filter_map(|disc| pillar(disc, heights, time_ns));
    let zones = described.zones.iter().enumerate().filter_map(|(i, region)| zone(region, i, time_ns));
    let lamps = described.lights.iter().filter_map(|light| lamp(light, heights, time_ns));
    scene(walls.chain(discs).chain(zones).chain(lamps).collect())
}

fn wall(polygon: &v1::Polygon, heights: &Heights, time_ns: u64) -> Option<SceneEntity> {
    let mut entity = entity(time_ns, WORLD, format!("wall/{}", polygon.name));
    let (rgb, span_m) =
        (palette::own(polygon.look.as_ref(), palette::WALL), heights.of(polygon.look.as_ref()));
    let paint = color(rgb, palette::WALL_ALPHA);
    if polygon.solid {
        Footprint::new(&polygon.points, None, 0.0)?.build(&mut entity, span_m, paint);
        return Some(entity);
    }
    let corners = corners(&polygon.points);
    if corners.len() < 2 {
        return None;
    }
    // A wall without thickness would not be seen from above.
    let kind = if polygon.closed { Line::LineLoop } else { Line::LineStrip };
    entity.lines.push(lines(kind, raised(&corners, span_m[1]), 2.0, color(rgb, 1.0)));
    entity.triangles.push(sides(&corners, polygon.closed, span_m, paint));
    Some(entity)
}

fn pillar(disc: &v1::Disc, heights: &Heights, time_ns: u64) -> Option<SceneEntity> {
    let mut entity = entity(time_ns, WORLD, format!("wall/{}", disc.name));
    let rgb = palette::own(disc.look.as_ref(), palette::WALL);
    let shape = Footprint::new(&[], disc.center.as_ref(), disc.radius_m)?;
    shape.build(&mut entity, heights.of(disc.look.as_ref()), color(rgb, palette::WALL_ALPHA));
    Some(entity)
}

fn zone(zone: &v1::Zone, place: usize, time_ns: u64) -> Option<SceneEntity> {
    let shape = Footprint::of_outline(zone.outline.as_ref()?)?;
    let mut entity = entity(time_ns, WORLD, format!("zone/{}", zone.zone));
    // Zones that lie on each other do not flicker.
    let z_m = 0.001 * (1 + place % 4) as f64;
    let uses = uses(zone);
    let (paint, uses) = (rgb(uses.color()), uses.words());
    if let Some(reflectance) = zone.floor.filter(|reflectance| reflectance.is_finite()) {
        let grey = (40.0 + 200.0 * reflectance.clamp(0.0, 1.0)) as u8;
        shape.paint(&mut entity, z_m, color([grey; 3], 1.0));
    } else {
        shape.paint(&mut entity, z_m, color(paint, 0.2));
    }
    entity.lines.push(lines(Line::LineLoop, raised(&shape.rim(), z_m), 1.5, color(paint, 1.0)));
    let text =
        if uses.is_empty() { zone.zone.clone() } else { format!("{}: {}", zone.zone, uses.join(", ")) };
    entity.texts.push(label(&text, shape.middle(), 0.01));
    Some(entity)
}

fn uses(zone: &v1::Zone) -> ZoneUses {
    let &v1::Zone { goal, charger_w, slip, indoors, floor, .. } = zone;
    ZoneUses { goal, charger_w, slip, indoors, floor, ..ZoneUses::default() }
}

fn lamp(light: &v1::Light, heights: &Heights, time_ns: u64) -> Option<SceneEntity> {
    let at = light.position.as_ref()?;
    if ![at.x_m, at.y_m, light.height_m].iter().all(|value| value.is_finite()) {
        return None;
    }
    let mut entity = entity(time_ns, WORLD, format!("light/{}", light.light));
    let width_m = 0.2 * heights.above();
    entity.spheres.push(SpherePrimitive {
        pose: Some(pose_at(at.x_m, at.y_m, light.height_m)),
        size: Some(vector(width_m, width_m, width_m)),
        color: Some(color(palette::LAMP, 1.0)),
    });
    entity.metadata.push(fact("intensity_cd", light.intensity_cd));
    Some(entity)
}

/// A text that faces the viewer.
pub(super) fn label(text: &str, [x_m, y_m]: [f64; 2], z_m: f64) -> TextPrimitive {
    TextPrimitive {
        pose: Some(pose_at(x_m, y_m, z_m)),
        billboard: true,
        font_size: 12.0,
        scale_invariant: true,
        color: Some(color(palette::TEXT, 1.0)),
        text: text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x_m: f64, y_m: f64) -> v1::Point {
        v1::Point { x_m, y_m }
    }

    fn room() -> v1::DescribeWorldResponse {
        let look = Some(v1::Look {
            height_m: Some(0.25),
            red: 255,
            blue: 51,
            lower_edge_m: 0.05,
            ..v1::Look::default()
        });
        let corners = vec![at(0.0, 0.0), at(2.0, 0.0), at(2.0, 1.0), at(0.0, 1.0)];
        let block =
            v1::Polygon { name: "block".into(), points: corners.clone(), solid: true, closed: true, look };
        let fence =
            v1::Polygon { name: "fence".into(), solid: false, closed: false, look: None, ..block.clone() };
        let post = v1::Disc { name: "post".into(), center: Some(at(3.0, 1.0)), radius_m: 0.5, look: None };
        let outline = Some(v1::Outline { points: corners, ..v1::Outline::default() });
        let zone =
            v1::Zone { zone: "home".into(), outline, goal: true, charger_w: 5.0, ..v1::Zone::default() };
        let light = v1::Light {
            light: "sun".into(),
            position: Some(at(1.0, 2.0)),
            height_m: 3.0,
            ..v1::Light::default()
        };
        v1::DescribeWorldResponse {
            polygons: vec![block, fence],
            circles: vec![post],
            zones: vec![zone],
            lights: vec![light],
            ..v1::DescribeWorldResponse::default()
        }
    }

    #[test]
    fn an_arena_is_what_was_described() {
        let described = room();
        let arena = arena(&described, &Heights::new(&described), 0);
        let ids: Vec<_> = arena.entities.iter().map(|entity| entity.id.as_str()).collect();
        assert_eq!(ids, ["wall/block", "wall/fence", "wall/post", "zone/home", "light/sun"]);
        assert!(arena.entities.iter().all(|entity| entity.frame_id == "world" && entity.lifetime.is_none()));
        let [block, fence, post, home, sun] = &arena.entities[..] else { unreachable!("five, as above") };
        let paint = block.triangles[0].color.unwrap();
        assert_eq!((paint.r, paint.g, paint.b), (1.0, 0.0, 0.2));
        assert!(block.triangles[0].points.iter().all(|point| point.z == 0.05 || point.z == 0.25));
        assert_eq!(fence.lines[0].r#type(), Line::LineStrip);
        assert_eq!(fence.lines[0].points.len(), 4);
        let column = &post.cylinders[0];
        assert_eq!(column.size.unwrap(), vector(1.0, 1.0, 0.3125));
        assert_eq!(column.pose.unwrap().position.unwrap(), vector(3.0, 1.0, 0.15625));
        assert_eq!(home.texts[0].text, "home: goal, charger 5 W");
        assert_eq!(home.texts[0].pose.unwrap().position.unwrap(), vector(1.0, 0.5, 0.01));
        assert_eq!(sun.spheres[0].pose.unwrap().position.unwrap(), vector(1.0, 2.0, 3.0));
    }

    #[test]
    fn what_is_nowhere_is_left_out() {
        let mut described = room();
        for polygon in &mut described.polygons {
            polygon.points[2].x_m = f64::NAN;
        }
        described.circles[0].radius_m = f64::INFINITY;
        described.zones[0].outline = None;
        described.lights[0].height_m = f64::NAN;
        assert!(arena(&described, &Heights::new(&described), 0).entities.is_empty());
    }
}

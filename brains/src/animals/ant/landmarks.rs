//! Landmarks in a scan: things that stand by themselves, such as a pillar on a plain.

use std::f64::consts::TAU;

/// A thing that a scan shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Landmark {
    /// The bearing of its middle, in radians to the left of the scan's middle.
    pub(super) bearing_rad: f64,
    /// The least distance to it, in metres.
    pub(super) distance_m: f64,
}

/// The things in a scan of so many radians, its rays from right to left; what is not positive, or not nearer than
/// `range_m`, met nothing. Rays side by side belong to one thing unless it jumps between them by more than `jump_m`. Where the
/// rays go all around, a thing may lie across the ends; a last ray that is the first again does not count.
pub(super) fn find(scan: &[f64], opening_rad: f64, range_m: f64, jump_m: f64) -> Vec<Landmark> {
    let step_rad = opening_rad / scan.len().saturating_sub(1).max(1) as f64;
    let is_ring = opening_rad + step_rad > TAU - 1e-6;
    let is_closed = opening_rad > TAU - 1e-6;
    let rays = if is_closed { scan.len().saturating_sub(1) } else { scan.len() };
    let bearing = |ray: usize| ray as f64 * step_rad - 0.5 * opening_rad;
    let hit = |ray: usize| Some(scan[ray % rays]).filter(|&distance| distance > 0.0 && distance < range_m);
    let joins =
        |a: Option<f64>, b: Option<f64>| matches!((a, b), (Some(a), Some(b)) if (a - b).abs() <= jump_m);
    // The walk begins where an object begins, so that nothing is cut in two there; a ring that is one wall has no
    // such place.
    let first = (0..rays).find(|&ray| !is_ring || !joins(hit(ray + rays - 1), hit(ray)));
    let Some(first) = first else { return Vec::new() };
    let mut found: Vec<(usize, usize, f64)> = Vec::new();
    for ray in first..first + rays {
        let Some(distance) = hit(ray) else { continue };
        match found.last_mut() {
            Some((_, last, nearest)) if *last + 1 == ray && joins(hit(*last), Some(distance)) => {
                (*last, *nearest) = (ray, nearest.min(distance));
            }
            _ => found.push((ray, ray, distance)),
        }
    }
    let landmark =
        |(from, to, distance_m)| Landmark { bearing_rad: 0.5 * (bearing(from) + bearing(to)), distance_m };
    found.into_iter().map(landmark).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// A scan of a full turn in steps of a degree that meets these things, each from a degree to a degree.
    fn ring(things: &[(i32, i32, f64)]) -> Vec<f64> {
        let at = |degree: i32| {
            let there = things.iter().find(|(from, to, _)| (degree - from).rem_euclid(360) <= to - from);
            there.map_or(-1.0, |(.., distance)| *distance)
        };
        (-180..=180).map(at).collect()
    }

    /// 360 rays a degree apart, of which the last is not the first again.
    #[test]
    fn rays_that_go_all_around_but_for_one_step_have_no_ends_either() {
        let mut scan = ring(&[(178, 184, 0.9)]);
        scan.pop();
        let found = find(&scan, 359.0_f64.to_radians(), 4.0, 0.3);
        assert_eq!(found.len(), 1, "{found:?}");
    }

    #[test]
    fn each_thing_is_found_once_and_in_its_middle() {
        let scan = ring(&[(-100, -96, 2.0), (10, 10, 1.5), (11, 13, 3.0), (176, 188, 0.9)]);
        let found = find(&scan, TAU, 4.0, 0.3);
        let degrees: Vec<_> =
            found.iter().map(|found| found.bearing_rad.to_degrees().round() as i32).collect();
        // The last lies across the ends, which is 182 degrees to the left.
        assert_eq!(degrees, [-98, 10, 12, 182]);
        assert_eq!(found[3].distance_m, 0.9);
        let near = find(&scan, TAU, 1.8, 0.3);
        assert_eq!(near.len(), 2, "{near:?}");
    }

    #[test]
    fn of_less_than_a_turn_the_ends_are_apart() {
        let scan = [1.0, 1.0, -1.0, 1.0, 1.0];
        let found = find(&scan, PI, 4.0, 0.3);
        let degrees: Vec<_> = found.iter().map(|found| found.bearing_rad.to_degrees()).collect();
        assert!((degrees[0] + 67.5).abs() < 1e-9 && (degrees[1] - 67.5).abs() < 1e-9, "{degrees:?}");
    }

    #[test]
    fn nothing_and_a_wall_all_around_are_no_landmarks() {
        assert!(find(&[-1.0; 361], TAU, 4.0, 0.3).is_empty());
        assert!(find(&[2.0; 361], TAU, 4.0, 0.3).is_empty());
        assert!(find(&[], TAU, 4.0, 0.3).is_empty() && find(&[1.0], TAU, 4.0, 0.3).is_empty());
    }
}

//! Directions that the openings between obstacles offer, and the cheapest of them.
//!
//! An opening is a run of free sectors. A narrow one offers its middle, a wide one a direction along either side of it, and
//! the direction to the goal if that is between these. The cost of a direction is μ₁ times its angle to the goal's direction,
//! μ₂ times that to the robot's heading, and μ₃ times that to the direction that was chosen before. With μ₁ > μ₂ + μ₃ it goes
//! to the goal in the end.

use std::f64::consts::TAU;

use baudbot_geometry::angle;

/// The directions that a candidate is compared with, in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// The direction to the goal.
    pub goal_rad: f64,
    /// The robot's heading.
    pub heading_rad: f64,
    /// The direction that was chosen before.
    pub previous_rad: f64,
    /// μ₁, μ₂ and μ₃.
    pub costs: [f64; 3],
    /// An opening is wide from this angle on.
    pub wide_rad: f64,
}

/// The cheapest direction that the masked histogram offers; `None` if all is blocked.
pub fn choose(masked: &[bool], wanted: &Wanted) -> Option<f64> {
    let cost = |direction: f64| {
        let others = [wanted.goal_rad, wanted.heading_rad, wanted.previous_rad];
        let angles = others.map(|other| angle::difference(direction, other).abs());
        (0..3).map(|i| wanted.costs[i] * angles[i]).sum::<f64>()
    };
    candidates(masked, wanted).into_iter().min_by(|a, b| cost(*a).total_cmp(&cost(*b)))
}

/// All directions that are offered.
pub fn candidates(masked: &[bool], wanted: &Wanted) -> Vec<f64> {
    let sector_rad = TAU / masked.len() as f64;
    let Some(first) = masked.iter().position(|blocked| *blocked) else { return vec![wanted.goal_rad] };
    let around = |i: usize| masked[(first + i) % masked.len()];
    let mut offered = Vec::new();
    // Openings, each from the sector after a blocked one to the one before the next.
    let mut right = None;
    for i in 1..=masked.len() {
        match (around(i), right) {
            (false, None) => right = Some(i),
            (true, Some(from)) => {
                let right_rad = (first + from) as f64 * sector_rad;
                offered.extend(of_opening(right_rad, (i - from) as f64 * sector_rad, wanted));
                right = None;
            }
            _ => {}
        }
    }
    offered
}

/// The directions through an opening of this width whose right side is in this direction.
fn of_opening(right_rad: f64, width_rad: f64, wanted: &Wanted) -> Vec<f64> {
    if width_rad <= wanted.wide_rad {
        return vec![right_rad + 0.5 * width_rad];
    }
    let from_side_rad = 0.5 * wanted.wide_rad;
    let mut offered = vec![right_rad + from_side_rad, right_rad + width_rad - from_side_rad];
    let goal_rad = (wanted.goal_rad - right_rad).rem_euclid(TAU);
    if (from_side_rad..=width_rad - from_side_rad).contains(&goal_rad) {
        offered.push(wanted.goal_rad);
    }
    offered
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 36 sectors of 10° of which these are blocked.
    fn blocked(ranges: &[(usize, usize)]) -> Vec<bool> {
        (0..36).map(|i| ranges.iter().any(|&(from, until)| (from..until).contains(&i))).collect()
    }

    fn wanted(goal_deg: f64) -> Wanted {
        let costs = [5.0, 2.0, 2.0];
        let goal_rad = goal_deg.to_radians();
        Wanted { goal_rad, heading_rad: 0.0, previous_rad: 0.0, costs, wide_rad: 60.0_f64.to_radians() }
    }

    fn chosen_deg(masked: &[bool], wanted: &Wanted) -> Option<f64> {
        choose(masked, wanted).map(|rad| angle::wrap(rad).to_degrees().round())
    }

    #[test]
    fn a_free_way_to_the_goal_is_taken() {
        assert_eq!(chosen_deg(&blocked(&[]), &wanted(70.0)), Some(70.0));
        assert_eq!(chosen_deg(&blocked(&[(18, 20)]), &wanted(-40.0)), Some(-40.0));
    }

    #[test]
    fn a_narrow_opening_offers_its_middle_and_a_wide_one_its_sides() {
        // Free from 0° to 40°.
        assert_eq!(chosen_deg(&blocked(&[(4, 36)]), &wanted(5.0)), Some(20.0));
        // Free from -90° to 40°, and the goal behind the left side of it.
        let wide = blocked(&[(4, 27)]);
        assert_eq!(chosen_deg(&wide, &wanted(60.0)), Some(10.0));
        assert_eq!(candidates(&wide, &wanted(60.0)).len(), 2);
        assert_eq!(candidates(&wide, &wanted(-20.0)).len(), 3);
        assert_eq!(chosen_deg(&blocked(&[(0, 36)]), &wanted(0.0)), None);
    }

    #[test]
    fn of_two_equal_ways_round_an_obstacle_the_one_chosen_before_stays() {
        let masked = blocked(&[(0, 3), (33, 36), (15, 21)]);
        for previous_deg in [-50.0_f64, 50.0] {
            let wanted = Wanted { previous_rad: previous_deg.to_radians(), ..wanted(0.0) };
            let chosen = choose(&masked, &wanted).map(angle::wrap).unwrap();
            assert!(chosen * previous_deg > 0.0, "{previous_deg}: {chosen}");
        }
    }
}

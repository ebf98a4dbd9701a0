//! The needs of a robot, and what they cost it in a run: McFarland's quadratic costs, Wahde 2016, §7.2.2.
//!
//! ```text
//! C = ∫ Σᵢ Qᵢ xᵢ² dt,    ẋᵢ = −rᵢ while the robot is in the need's zone
//! ```
//!
//! Within a tick a deficit falls evenly, so C is exact. `baudbot_brains::decision::quadratic` has its closed form for a robot that is
//! always in one of the zones; what is driven between them costs more.

use baudbot_brains::decision::quadratic::Need;

/// A need, and the zone that satisfies it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deficit {
    /// The zone's place in the scenario.
    pub(crate) zone: usize,
    /// The need at the start.
    pub(crate) need: Need,
}

/// The cost of needs so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Cost {
    deficits: Vec<Deficit>,
    so_far: f64,
}

impl Cost {
    pub(crate) fn new(deficits: &[Deficit]) -> Self {
        Self { deficits: deficits.to_vec(), so_far: 0.0 }
    }

    /// Goes on by `dt_s` seconds, of which the robot was in each zone for so many.
    pub(crate) fn step(&mut self, dt_s: f64, in_zone_s: impl Fn(usize) -> f64) {
        for Deficit { zone, need } in &mut self.deficits {
            let before = need.deficit;
            need.deficit = (before - need.rate * in_zone_s(*zone)).max(0.0);
            let after = need.deficit;
            self.so_far += need.importance * (before * before + before * after + after * after) / 3.0 * dt_s;
        }
    }

    /// C; `None` without needs.
    pub(crate) fn total(&self) -> Option<f64> {
        (!self.deficits.is_empty()).then_some(self.so_far)
    }
}

#[cfg(test)]
mod tests {
    use baudbot_brains::decision::quadratic::cost_in_order;

    use super::*;

    /// §7.2.2: the integral over a run is the closed form, in both orders.
    #[test]
    fn who_satisfies_one_need_after_the_other_pays_what_the_closed_form_says() {
        let hunger = Need { deficit: 0.6, importance: 1.0, rate: 0.005 };
        let thirst = Need { deficit: 0.4, importance: 2.0, rate: 0.01 };
        for order in [[hunger, thirst], [thirst, hunger]] {
            let deficit = |(zone, need)| Deficit { zone, need };
            let deficits: Vec<_> = order.into_iter().enumerate().map(deficit).collect();
            let mut cost = Cost::new(&deficits);
            for (place, need) in order.iter().enumerate() {
                let steps = (need.deficit / need.rate / 0.01).round() as u32;
                (0..steps).for_each(|_| cost.step(0.01, |zone| if zone == place { 0.01 } else { 0.0 }));
            }
            let closed = cost_in_order(&order);
            assert!((cost.total().unwrap() / closed - 1.0).abs() < 1e-9, "{cost:?} {closed}");
        }
        assert_eq!(Cost::default().total(), None);
    }
}

//! Quadratic costs: the needs of an animal, and the order in which to satisfy them. Wahde 2016, §7.2.2; after D. McFarland and
//! T. Bösser, *Intelligent Behavior in Animals and Robots*, 1993.
//!
//! A need has a deficit x, which costs Q x² per second, and which falls by r per second while the animal satisfies it. The animal does
//! one thing at a time. The notes name the method and give no equations; these are the simplest of that kind, and have a closed form.
//!
//! ```text
//! C = ∫ Σᵢ Qᵢ xᵢ² dt,    ẋᵢ = −rᵢ uᵢ,    Σᵢ uᵢ = 1
//! ```
//!
//! *One after the other.* If A is satisfied wholly before B, B's deficit stands for A's time: C(A, B) − C(B, A) has the sign of
//! r_B Q_B x_B − r_A Q_A x_A. So the need with the greatest *urgency* r Q x comes first.
//!
//! *In turns.* The optimum satisfies the most urgent need until another is as urgent, and then shares the time so that they stay equally
//! urgent to the end, which is dithering without end where a change costs nothing.

/// A need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// x: the deficit, in units of its own; at least 0.
    pub deficit: f64,
    /// Q: the cost of a deficit of 1, per second; above 0.
    pub importance: f64,
    /// r: the part of the deficit that is satisfied in a second; above 0.
    pub rate: f64,
}

impl Need {
    /// r Q x: the saving by a moment of satisfying it, halved.
    pub fn urgency(&self) -> f64 {
        self.rate * self.importance * self.deficit
    }

    /// The time to satisfy it wholly, in seconds.
    fn time_s(&self) -> f64 {
        self.deficit / self.rate
    }

    /// The cost while it is satisfied wholly: ∫ Q (x − r t)² dt.
    fn cost_while_satisfied(&self) -> f64 {
        self.importance * self.deficit.powi(3) / (3.0 * self.rate)
    }
}

/// The cost if the needs are satisfied wholly, one after the other, in this order.
///
/// ```
/// use baudbot_brains::decision::quadratic::{Need, cost_in_order};
/// let hunger = Need { deficit: 3.0, importance: 1.0, rate: 1.0 };
/// let thirst = Need { deficit: 2.0, importance: 1.0, rate: 2.0 };
/// assert!(cost_in_order(&[thirst, hunger]) < cost_in_order(&[hunger, thirst])); // 4 is more urgent than 3
/// ```
pub fn cost_in_order(needs: &[Need]) -> f64 {
    let mut cost = 0.0;
    for (place, need) in needs.iter().enumerate() {
        let waiting: f64 = needs[place + 1..].iter().map(|need| need.importance * need.deficit.powi(2)).sum();
        cost += need.cost_while_satisfied() + waiting * need.time_s();
    }
    cost
}

/// The cheapest order in which to satisfy needs wholly: their places, the most urgent first; of equal ones the first.
pub fn cheapest_order(needs: &[Need]) -> Vec<usize> {
    let mut order: Vec<_> = (0..needs.len()).collect();
    order.sort_by(|a, b| needs[*b].urgency().total_cmp(&needs[*a].urgency()));
    order
}

/// The least cost of two needs if the animal may change at any time at no cost: the more urgent one alone until both are equally urgent,
/// then both in turns.
pub fn least_cost_in_turns(needs: [Need; 2]) -> f64 {
    let [first, second] = cheapest_order(&needs)[..] else { return 0.0 };
    let (alone, waits) = (needs[first], needs[second]);
    // The deficit at which it is only as urgent as the other.
    let then = waits.urgency() / (alone.rate * alone.importance);
    let alone_s = (alone.deficit - then) / alone.rate;
    let alone_cost = alone.importance * (alone.deficit.powi(3) - then.powi(3)) / (3.0 * alone.rate)
        + waits.importance * waits.deficit.powi(2) * alone_s;
    // From there both fall in proportion, to 0 at the same time: a quadratic falls to 0 with a third of its first value on average.
    let both_s = then / alone.rate + waits.time_s();
    let both_cost =
        (alone.importance * then.powi(2) + waits.importance * waits.deficit.powi(2)) * both_s / 3.0;
    alone_cost + both_cost
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    fn need(chance: &mut Chance) -> Need {
        let mut draw = || 0.1 + 3.0 * chance.uniform();
        Need { deficit: draw(), importance: draw(), rate: draw() }
    }

    /// By the trapezoid rule, always satisfying what this chooses.
    fn integrated(mut needs: Vec<Need>, dt_s: f64, choose: impl Fn(&[Need]) -> usize) -> f64 {
        let cost =
            |needs: &[Need]| -> f64 { needs.iter().map(|need| need.importance * need.deficit.powi(2)).sum() };
        let mut sum = 0.0;
        while needs.iter().any(|need| need.deficit > 0.0) {
            let before = cost(&needs);
            let chosen = choose(&needs);
            needs[chosen].deficit = (needs[chosen].deficit - needs[chosen].rate * dt_s).max(0.0);
            sum += 0.5 * dt_s * (before + cost(&needs));
        }
        sum
    }

    /// Quadratic costs (§7.2.2), beside all orders that there are.
    #[test]
    fn the_cheapest_of_all_orders_is_by_urgency() {
        let mut chance = Chance::new(1, "needs");
        for _ in 0..200 {
            let needs: Vec<_> = (0..4).map(|_| need(&mut chance)).collect();
            let cost = |order: &[usize]| cost_in_order(&order.iter().map(|&i| needs[i]).collect::<Vec<_>>());
            let cheapest = cost(&cheapest_order(&needs));
            for a in 0..4 {
                for b in (0..4).filter(|b| *b != a) {
                    for c in (0..4).filter(|c| ![a, b].contains(c)) {
                        let order = [a, b, c, 6 - a - b - c];
                        assert!(cheapest <= cost(&order) + 1e-9, "{needs:?}: {order:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_closed_forms_are_those_of_a_course_in_small_steps() {
        let mut chance = Chance::new(2, "needs");
        for _ in 0..20 {
            let needs = [need(&mut chance), need(&mut chance)];
            let order = cheapest_order(&needs);
            let in_order = integrated(needs.to_vec(), 1e-4, |now| {
                if now[order[0]].deficit > 0.0 { order[0] } else { order[1] }
            });
            let closed = cost_in_order(&[needs[order[0]], needs[order[1]]]);
            assert!((in_order / closed - 1.0).abs() < 1e-3, "{needs:?}: {in_order} and {closed}");
            let in_turns = integrated(needs.to_vec(), 1e-4, |now| cheapest_order(now)[0]);
            let least = least_cost_in_turns(needs);
            assert!((in_turns / least - 1.0).abs() < 1e-3, "{needs:?}: {in_turns} and {least}");
            assert!(least <= closed + 1e-9);
        }
    }

    /// No schedule is cheaper: the least of all schedules in parts of a fortieth of each deficit, by dynamic programming.
    #[test]
    fn no_schedule_is_cheaper_than_in_turns() {
        const PARTS: usize = 40;
        let mut chance = Chance::new(3, "needs");
        for _ in 0..20 {
            let needs = [need(&mut chance), need(&mut chance)];
            let left = |i: usize, parts: usize| needs[i].deficit * parts as f64 / PARTS as f64;
            let part_s = |i: usize| needs[i].time_s() / PARTS as f64;
            // The cost from here to the end, by the parts that are left of both.
            let mut least = vec![vec![0.0_f64; PARTS + 1]; PARTS + 1];
            for a in 0..=PARTS {
                for b in 0..=PARTS {
                    let squares = |i: usize, before: usize| {
                        let (x, y) = (left(i, before), left(i, before - 1));
                        needs[i].importance * (x * x + x * y + y * y) / 3.0
                    };
                    let stands = |i: usize, parts: usize| needs[i].importance * left(i, parts).powi(2);
                    let by_a = || least[a - 1][b] + part_s(0) * (squares(0, a) + stands(1, b));
                    let by_b = || least[a][b - 1] + part_s(1) * (squares(1, b) + stands(0, a));
                    least[a][b] = match (a, b) {
                        (0, 0) => 0.0,
                        (0, _) => by_b(),
                        (_, 0) => by_a(),
                        (_, _) => by_a().min(by_b()),
                    };
                }
            }
            let (closed, found) = (least_cost_in_turns(needs), least[PARTS][PARTS]);
            assert!(
                closed <= found * (1.0 + 1e-9) && found < closed * 1.01,
                "{needs:?}: {closed} and {found}"
            );
        }
    }
}

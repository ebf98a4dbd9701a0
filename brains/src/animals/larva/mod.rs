//! The larva of a flesh fly (*Sarcophaga*): away from light, and a reflex that tires. Wahde 2016, §4.4.1 and
//! §4.4.2.
//!
//! **Taxis.** A larva turns away from the side on which it is brighter. With eyes on both sides it compares them at
//! once: [`Larva::step`]. With a single one it swings its head, and compares what it saw on the left with what it
//! saw on the right (klinotaxis): [`Larva::step_swinging`].
//!
//! **Fatigue.** Turning is a reflex, and a reflex tires though muscles and eyes do not: its circuit is exhausted.
//! The notes describe a larva in a tunnel with its only light at the entrance. It crawls to the dead end, turns
//! about there, and then crawls *towards* the light and out. In the open it never would.
//!
//! The notes have no equations. Here c = (L − R) / (L + R) is the contrast of both sides, s the strength of the
//! stimulus, which grows from 0 to 1 between two contrasts, and F the vigour of the reflex, from 0 to 1:
//!
//! - turn rate −sgn(c) ω s F, and speed v (1 − s F): a larva that turns with all its might does not crawl;
//! - dF/dt = (1 − F) / τ_recovery − s F / τ_fatigue.
//!
//! In the open a turn lasts until the light is behind, a second or two, so F stays near 1. In the tunnel the walls
//! hold the body, the stimulus does not end, F falls to τ_recovery⁻¹ / (τ_recovery⁻¹ + τ_fatigue⁻¹), and the larva
//! crawls on.

pub(crate) mod brain;
mod swing;

pub use brain::{LarvaBrain, Parameters as BrainParameters};

use super::sense::Sides;
use super::wheel_commands::Motion;
use swing::Swing;

/// Parameters of a larva.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// v, its speed when it does not turn, in m/s.
    pub crawl_m_s: f64,
    /// ω, how fast it turns at most, in rad/s.
    pub turn_rad_s: f64,
    /// Contrast of the sides up to which it does not turn.
    pub least_contrast: f64,
    /// Contrast of the sides from which it turns as fast as it can; above the least one.
    pub full_contrast: f64,
    /// τ_fatigue, in seconds: so long it can turn with all its might. Infinite for a reflex that does not tire.
    pub fatigue_s: f64,
    /// The time constant of recovery τ_recovery, in seconds.
    pub recovery_s: f64,
    /// The swing of its head to either side, in radians.
    pub swing_rad: f64,
    /// The frequency of the swings of its head, per second.
    pub swing_hz: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            crawl_m_s: 0.2,
            turn_rad_s: 1.0,
            least_contrast: 0.05,
            full_contrast: 0.25,
            fatigue_s: 5.0,
            recovery_s: 20.0,
            swing_rad: 0.5,
            swing_hz: 0.5,
        }
    }
}

/// A larva.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Larva {
    parameters: Parameters,
    vigour: f64,
    swing: Swing,
}

impl Larva {
    /// A larva that is not tired, with its head straight on.
    pub fn new(parameters: Parameters) -> Self {
        Self { parameters, vigour: 1.0, swing: Swing::new(parameters.swing_rad, parameters.swing_hz) }
    }

    /// F, how ready its reflex is, from 0 to 1.
    pub fn vigour(&self) -> f64 {
        self.vigour
    }

    /// The direction of its head, in radians to the left of its body.
    pub fn head_rad(&self) -> f64 {
        self.swing.angle_rad()
    }

    /// The larva's motion for `dt_s` seconds with so much light on its left and on its right.
    pub fn step(&mut self, light: Sides, dt_s: f64) -> Motion {
        let p = self.parameters;
        let contrast = contrast(light);
        let range = (p.full_contrast - p.least_contrast).max(f64::MIN_POSITIVE);
        let stimulus = ((contrast.abs() - p.least_contrast) / range).clamp(0.0, 1.0);
        let reflex = stimulus * self.vigour;
        // Euler's method; a step of more than a time constant must not take the vigour out of its range.
        let change = (1.0 - self.vigour) / p.recovery_s - reflex / p.fatigue_s;
        self.vigour = (self.vigour + dt_s * change).clamp(0.0, 1.0);
        Motion {
            speed_m_s: p.crawl_m_s * (1.0 - reflex),
            turn_rate_rad_s: -contrast.signum() * p.turn_rad_s * reflex,
        }
    }

    /// The same with one eye, in the head, that sees so much light where the head now points. The head swings on;
    /// the motion is that of the body. Until it has swung to both sides there is nothing to compare.
    pub fn step_swinging(&mut self, light: f64, dt_s: f64) -> Motion {
        let sides = self.swing.see(light, dt_s);
        self.step(sides, dt_s)
    }
}

/// (L − R) / (L + R), from −1 to 1; 0 in the dark.
fn contrast(light: Sides) -> f64 {
    let sum = light.left + light.right;
    if sum > 0.0 { ((light.left - light.right) / sum).clamp(-1.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use baudbot_geometry::{Point, Pose, Vector, angle, math};

    use super::*;

    const DT_S: f64 = 0.01;

    /// The light that falls on a surface at `pose` from a lamp at the origin.
    fn light(pose: &Pose) -> f64 {
        let to_lamp = -pose.position.coords;
        let cos = to_lamp.dot(&pose.direction().vector()) / to_lamp.norm();
        cos.max(0.0) / to_lamp.norm_squared()
    }

    /// The light on an eye whose direction is this bearing: to the left, or to the right if negative.
    fn seen(pose: &Pose, bearing_rad: f64) -> f64 {
        light(&pose.compose(&Pose::new(0.0, 0.0, bearing_rad)))
    }

    fn two_eyes(larva: &mut Larva, pose: &Pose) -> Motion {
        larva.step(Sides { left: seen(pose, 0.6), right: seen(pose, -0.6) }, DT_S)
    }

    fn one_eye(larva: &mut Larva, pose: &Pose) -> Motion {
        let head_rad = larva.head_rad();
        larva.step_swinging(seen(pose, head_rad), DT_S)
    }

    fn moved(pose: &Pose, motion: Motion) -> Pose {
        let displacement = Vector::new(motion.speed_m_s * DT_S, 0.0);
        pose.compose(&Pose { position: Point::from(displacement), heading: motion.turn_rate_rad_s * DT_S })
    }

    /// Taxis away from light (§4.4.2).
    #[test]
    fn in_the_open_it_turns_from_the_light_and_leaves() {
        for step in [two_eyes, one_eye] {
            for i in 0..16 {
                let mut larva = Larva::new(Parameters::default());
                // The headings go from nearly towards the lamp to away from it: a larva that points straight at it sees
                // no contrast.
                let mut pose = Pose::new(1.0, 0.0, PI - 0.2 - 0.38 * f64::from(i));
                for _ in 0..2500 {
                    pose = moved(&pose, step(&mut larva, &pose));
                }
                let away =
                    angle::difference(pose.heading, math::atan2(pose.position.y, pose.position.x)).abs();
                assert!(away < 1.2 && pose.position.coords.norm() > 2.5, "{i}: {pose:?}");
                assert!(larva.vigour() > 0.6, "{i}: {}", larva.vigour());
            }
        }
    }

    /// The time, in seconds, after which a larva leaves a tunnel of 1 m with a dead end; `None` if it does not within
    /// five minutes. The walls hold its body within 0.8 rad of their direction, and at the end they turn it about.
    fn leaves_tunnel_after_s(parameters: Parameters) -> (Option<f64>, f64) {
        let mut larva = Larva::new(parameters);
        // The lamp is 0.2 m in front of the entrance.
        let (entrance, end) = (0.2, 1.2);
        let (mut pose, mut along, mut deepest) = (Pose::new(0.3, 0.0, 0.1), 0.0, 0.0_f64);
        for step in 0..30_000 {
            let Pose { position, heading } = moved(&pose, two_eyes(&mut larva, &pose));
            let aside = angle::difference(heading, along).clamp(-0.8, 0.8);
            pose = Pose::new(position.x, 0.0, along + aside);
            deepest = deepest.max(pose.position.x);
            if pose.position.x > end && along == 0.0 {
                along = PI;
                pose.heading += PI;
            }
            if pose.position.x < entrance {
                return (Some(f64::from(step) * DT_S), deepest);
            }
        }
        (None, deepest)
    }

    #[test]
    fn out_of_a_tunnel_it_crawls_towards_the_light_once_its_reflex_is_tired() {
        let (left_s, deepest) = leaves_tunnel_after_s(Parameters::default());
        assert!(deepest > 1.19, "first it goes to the end: {deepest}");
        assert!(left_s.is_some_and(|seconds| seconds > 10.0), "{left_s:?}");
        let tireless = Parameters { fatigue_s: f64::INFINITY, ..Parameters::default() };
        let (left_s, deepest) = leaves_tunnel_after_s(tireless);
        assert!(left_s.is_none() && deepest > 1.19, "{left_s:?} {deepest}");
    }

    /// The fatigue of §4.4.1.
    #[test]
    fn a_reflex_tires_and_recovers_as_its_equation_says() {
        let mut larva = Larva::new(Parameters::default());
        let bright_left = Sides { left: 1.0, right: 0.0 };
        let first = larva.step(bright_left, DT_S);
        assert_eq!(first, Motion { speed_m_s: 0.0, turn_rate_rad_s: -1.0 });
        for _ in 0..10_000 {
            larva.step(bright_left, DT_S);
        }
        assert!((larva.vigour() - 0.2).abs() < 1e-6, "{}", larva.vigour());
        let tired = larva.step(bright_left, DT_S);
        assert!(
            (tired.speed_m_s - 0.16).abs() < 1e-6 && (tired.turn_rate_rad_s + 0.2).abs() < 1e-6,
            "{tired:?}"
        );
        // In the dark it recovers, by all but 1/e of what it lacks in 20 s.
        for _ in 0..2000 {
            larva.step(Sides::default(), DT_S);
        }
        assert!((larva.vigour() - (1.0 - 0.8 * (-1.0_f64).exp())).abs() < 1e-3, "{}", larva.vigour());
    }

    #[test]
    fn the_sides_are_treated_alike() {
        let turn_rate =
            |left, right| Larva::new(Parameters::default()).step(Sides { left, right }, DT_S).turn_rate_rad_s;
        assert!(turn_rate(3.0, 2.5) < 0.0);
        assert_eq!(turn_rate(3.0, 2.5), -turn_rate(2.5, 3.0));
        assert_eq!(turn_rate(2.0, 2.1), 0.0, "too little contrast");
    }
}

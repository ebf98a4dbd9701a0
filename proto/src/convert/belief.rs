//! The beliefs that a brain publishes.

use baudbot_brain::{
    Belief, BelievedPose, GridMap, Motivation, Particle, Point, StateVariable, Tendency, Utility,
};

use crate::v1;

impl From<Belief> for v1::Belief {
    fn from(belief: Belief) -> Self {
        let Belief { state, utilities, pose, particles, path, map, motivation } = belief;
        Self {
            state,
            utilities: utilities.into_iter().map(Into::into).collect(),
            pose: pose.map(Into::into),
            particles: particles.into_iter().map(Into::into).collect(),
            path: path.into_iter().map(Into::into).collect(),
            map: map.map(Into::into),
            motivation: motivation.map(Into::into),
        }
    }
}

impl From<Utility> for v1::Utility {
    fn from(Utility { name, value, active }: Utility) -> Self {
        Self { name, value, active }
    }
}

impl From<Motivation> for v1::Motivation {
    fn from(Motivation { variables, tendencies }: Motivation) -> Self {
        Self {
            variables: variables.into_iter().map(Into::into).collect(),
            tendencies: tendencies.into_iter().map(Into::into).collect(),
        }
    }
}

impl From<StateVariable> for v1::StateVariable {
    fn from(StateVariable { name, value, internal, lethal }: StateVariable) -> Self {
        let [lethal_below, lethal_above] = lethal;
        Self { name, value, internal, lethal_below, lethal_above }
    }
}

impl From<Tendency> for v1::Tendency {
    fn from(Tendency { name, bias, weights }: Tendency) -> Self {
        Self { name, bias, weights }
    }
}

impl From<BelievedPose> for v1::BelievedPose {
    fn from(BelievedPose { x_m, y_m, heading_rad, covariance_m2 }: BelievedPose) -> Self {
        Self { x_m, y_m, heading_rad, covariance_m2: covariance_m2.into_iter().flatten().collect() }
    }
}

impl From<Particle> for v1::Particle {
    fn from(Particle { x_m, y_m, heading_rad, weight }: Particle) -> Self {
        Self { x_m, y_m, heading_rad, weight }
    }
}

impl From<Point> for v1::Point {
    fn from(Point { x_m, y_m }: Point) -> Self {
        Self { x_m, y_m }
    }
}

impl From<GridMap> for v1::GridMap {
    fn from(GridMap { x_m, y_m, cell_m, columns, cells }: GridMap) -> Self {
        Self { x_m, y_m, cell_m, columns, cells }
    }
}

impl v1::Motivation {
    /// All of its numbers, of which each must be finite.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let variables = self.variables.iter().flat_map(|variable| {
            let lethal = [variable.lethal_below, variable.lethal_above].into_iter().flatten();
            std::iter::once(variable.value).chain(lethal)
        });
        let tendencies = self.tendencies.iter();
        let tendencies = tendencies
            .flat_map(|tendency| std::iter::once(tendency.bias).chain(tendency.weights.iter().copied()));
        variables.chain(tendencies)
    }
}

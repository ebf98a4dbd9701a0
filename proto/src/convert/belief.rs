//! The beliefs that a brain publishes.

use baudbot_brain::{Belief, BelievedPose, GridMap, Particle, Point, Utility};

use crate::v1;

impl From<Belief> for v1::Belief {
    fn from(belief: Belief) -> Self {
        let Belief { state, utilities, pose, particles, path, map } = belief;
        Self {
            state,
            utilities: utilities.into_iter().map(Into::into).collect(),
            pose: pose.map(Into::into),
            particles: particles.into_iter().map(Into::into).collect(),
            path: path.into_iter().map(Into::into).collect(),
            map: map.map(Into::into),
        }
    }
}

impl From<Utility> for v1::Utility {
    fn from(Utility { name, value, active }: Utility) -> Self {
        Self { name, value, active }
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

//! The parameters of exploration.

use std::f64::consts::PI;

use serde::Deserialize;

use crate::exploration::nodes;
use crate::parameter::Parameter;
use crate::proximity_sensors;

/// The parameters of exploration. The lengths of the methods that are not here follow the body, as do those that are 0.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// 0: by nodes; 1: by frontiers. What is in between is rounded.
    pub method: f64,
    /// 1: the odometer is corrected by scans, see [`slam`](crate::slam); 0: it is believed. What is in between is rounded.
    pub slam: f64,
    /// The distance from the robot at which nodes are placed, D, in metres; 0: five radii of the body, and half a
    /// metre at least.
    pub distance_m: f64,
    /// Room behind a node, Δ, in metres; 0: six tenths of D.
    pub margin_m: f64,
    /// Width of a feasible angular interval, `γ_min`, in radians; 0: as wide as the robot needs at the distance D.
    pub width_rad: f64,
    /// The least distance between nodes, d, in metres; 0: 0.95 D.
    pub separation_m: f64,
    /// The greatest distance of a node that is gone to directly, L, in metres; 0: 3 D. If the laser's range is less,
    /// that counts.
    pub sight_m: f64,
    /// Side of the cells of the map in which frontiers are found, in metres; 0: an eighth of the body's radius.
    pub cell_m: f64,
    /// Speed at which it drives, in m/s; less where there is little room.
    pub speed_m_s: f64,
    /// Rate at which it turns on the spot, in rad/s.
    pub turn_rate_rad_s: f64,
    /// Speed of a wheel at signal 1, in m/s, about: what is wrong with it the odometer shows.
    pub full_speed_m_s: f64,
    /// The distance within which an object on the robot's way is near to a sonar or the laser, in metres; 0: three
    /// quarters of the body's radius.
    pub near_m: f64,
    /// An infra-red reading from which something is near.
    pub near_reading: f64,
    /// The time without a reading of the odometer after which the robot stands still, in seconds.
    pub stale_s: f64,
}

impl Parameters {
    pub(crate) fn stale_ns(&self) -> u64 {
        (self.stale_s * 1e9) as u64
    }
}

impl Parameters {
    /// The same, with what a body of this radius needs, in metres, for what is 0.
    pub(crate) fn of_body(self, radius_m: f64) -> Self {
        let nodes = nodes::Parameters::of_body(radius_m);
        let or = |set: f64, of_body: f64| if set > 0.0 { set } else { of_body };
        let distance_m = or(self.distance_m, nodes.placement.distance_m);
        // The nodes' distances follow from this one, whatever its source.
        let times = distance_m / nodes.placement.distance_m;
        Self {
            distance_m,
            margin_m: or(self.margin_m, times * nodes.placement.margin_m),
            separation_m: or(self.separation_m, times * nodes.placement.separation_m),
            sight_m: or(self.sight_m, times * nodes.sight_m),
            cell_m: or(self.cell_m, nodes.map.cell_m),
            near_m: or(self.near_m, proximity_sensors::near_m(radius_m)),
            ..self
        }
    }
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            method: 0.0,
            slam: 0.0,
            distance_m: 0.0,
            margin_m: 0.0,
            width_rad: 0.0,
            separation_m: 0.0,
            sight_m: 0.0,
            cell_m: 0.0,
            speed_m_s: 0.3,
            turn_rate_rad_s: 0.8,
            full_speed_m_s: 0.8,
            near_m: 0.0,
            near_reading: 0.4,
            stale_s: 0.5,
        }
    }
}

pub(crate) const PARAMETERS: &[Parameter<Parameters>] = &[
    Parameter {
        name: "method",
        meaning: "0: by nodes (Wahde 2016, §6.1); 1: by frontiers (Yamauchi 1997)",
        range: 0.0..=1.0,
        field: |p| &mut p.method,
    },
    Parameter {
        name: "slam",
        meaning: "1: scans correct the odometer; 0: the odometer is used uncorrected, as in the notes",
        range: 0.0..=1.0,
        field: |p| &mut p.slam,
    },
    Parameter {
        name: "distance_m",
        meaning: "distance from the robot at which nodes are placed, in metres; 0: five radii of the body, at least 0.5",
        range: 0.0..=100.0,
        field: |p| &mut p.distance_m,
    },
    Parameter {
        name: "margin_m",
        meaning: "free distance behind a node, in metres; 0: six tenths of distance_m",
        range: 0.0..=100.0,
        field: |p| &mut p.margin_m,
    },
    Parameter {
        name: "width_rad",
        meaning: "width of a feasible angular interval, in radians; 0: as the body needs",
        range: 0.0..=2.0 * PI,
        field: |p| &mut p.width_rad,
    },
    Parameter {
        name: "separation_m",
        meaning: "least distance between nodes, in metres; 0: 0.95 times distance_m",
        range: 0.0..=100.0,
        field: |p| &mut p.separation_m,
    },
    Parameter {
        name: "sight_m",
        meaning: "largest distance of a node that is driven to directly, in metres; 0: three times that",
        range: 0.0..=1000.0,
        field: |p| &mut p.sight_m,
    },
    Parameter {
        name: "cell_m",
        meaning: "side of the cells of the map, in metres; 0: an eighth of the body's radius",
        range: 0.0..=10.0,
        field: |p| &mut p.cell_m,
    },
    Parameter {
        name: "speed_m_s",
        meaning: "speed at which it drives, in m/s",
        range: 0.001..=100.0,
        field: |p| &mut p.speed_m_s,
    },
    Parameter {
        name: "turn_rate_rad_s",
        meaning: "rate at which it turns on the spot, in rad/s",
        range: 0.001..=100.0,
        field: |p| &mut p.turn_rate_rad_s,
    },
    Parameter {
        name: "full_speed_m_s",
        meaning: "speed of a wheel at signal 1, in m/s",
        range: 0.001..=100.0,
        field: |p| &mut p.full_speed_m_s,
    },
    Parameter {
        name: "near_m",
        meaning: "distance ahead within which an obstacle that a sonar or the laser sees is in the way, in metres; 0: three quarters of the body's radius",
        range: 0.0..=100.0,
        field: |p| &mut p.near_m,
    },
    Parameter {
        name: "near_reading",
        meaning: "infra-red reading from which something is near",
        range: 0.0..=1.0,
        field: |p| &mut p.near_reading,
    },
    Parameter {
        name: "stale_s",
        meaning: "time without a reading of the odometer after which it stands still, in seconds",
        range: 0.01..=60.0,
        field: |p| &mut p.stale_s,
    },
];

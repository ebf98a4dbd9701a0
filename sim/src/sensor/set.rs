//! The sensors of a robot, with what follows from them.

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::Deref;

use super::Sensor;
use crate::vicinity::Reach;

/// The sensors of a robot: those that the microcontroller reads, in the order of the wire, then those with a cable of their
/// own. A clone shares them.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensors(Arc<Parts>);

#[derive(Debug, PartialEq)]
struct Parts {
    all: Vec<Sensor>,
    own_clocks: Vec<usize>,
    ports: Vec<usize>,
    reach: Option<Reach>,
}

impl Sensors {
    /// The indices of the sensors that measure at their own pace.
    pub fn own_clocks(&self) -> &[usize] {
        &self.0.own_clocks
    }

    /// The indices of the sensors with a cable of their own.
    pub fn ports(&self) -> &[usize] {
        &self.0.ports
    }

    /// How far the sensors look that see what is near; `None` if collecting that once for all of them would not pay.
    pub(crate) fn reach(&self) -> Option<Reach> {
        self.0.reach
    }
}

impl From<Vec<Sensor>> for Sensors {
    fn from(all: Vec<Sensor>) -> Self {
        let indices = |wanted: fn(&Sensor) -> bool| {
            all.iter().enumerate().filter(|(_, sensor)| wanted(sensor)).map(|(i, _)| i).collect()
        };
        let own_clocks = indices(|sensor| sensor.own_clock.is_some());
        let ports = indices(|sensor| sensor.port.is_some());
        let reach = Reach::of(&all);
        Self(Arc::new(Parts { all, own_clocks, ports, reach }))
    }
}

impl Deref for Sensors {
    type Target = [Sensor];

    fn deref(&self) -> &[Sensor] {
        &self.0.all
    }
}

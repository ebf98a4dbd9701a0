//! The sensors of a robot, with what follows from them.

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::Deref;

use baudbot_geometry::Fan;

use super::{Device, Infrared, InfraredModel, Sensor};
use crate::heap::{SHARED, elements, list};
use crate::scene::{Reach, Sector};

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
    /// Of each sensor that `reach` is of, if it has one.
    sectors: Vec<Option<Sector>>,
}

impl Sensors {
    /// The address, which tells it from others: clones have the same.
    pub(crate) fn address(&self) -> usize {
        Arc::as_ptr(&self.0).addr()
    }

    /// The bytes that they have on the heap.
    pub(crate) fn heap_bytes(&self) -> usize {
        let Parts { all, own_clocks, ports, sectors, .. } = &*self.0;
        let sensors =
            list(all, |sensor| sensor.name.capacity() + elements(&sensor.encodings) + device(&sensor.device));
        SHARED + size_of::<Parts>() + sensors + elements(own_clocks) + elements(ports) + elements(sectors)
    }

    /// The indices of the sensors that measure at their own pace.
    pub fn own_clocks(&self) -> &[usize] {
        &self.0.own_clocks
    }

    /// The indices of the sensors with a cable of their own.
    pub fn ports(&self) -> &[usize] {
        &self.0.ports
    }

    /// Whether one of them measures forces of contacts.
    pub(crate) fn feel_contacts(&self) -> bool {
        self.iter().any(|sensor| matches!(sensor.device, Device::StrainGauge(_)))
    }

    /// Those that the microcontroller reads.
    pub(crate) fn on_wire(&self) -> &[Sensor] {
        &self.0.all[..self.0.all.len() - self.0.ports.len()]
    }

    /// The range of the sensors that see near shapes; `None` if collecting those once for all of them would not pay.
    pub(crate) fn reach(&self) -> Option<Reach> {
        self.0.reach
    }

    /// The sector of sensor `i`'s rays, if it reads 0 when these meet nothing, is one of those that `reach` is of,
    /// and does not turn on the body.
    pub(crate) fn sector(&self, i: usize) -> Option<&Sector> {
        self.0.sectors[i].as_ref()
    }
}

impl From<Vec<Sensor>> for Sensors {
    fn from(all: Vec<Sensor>) -> Self {
        let indices = |wanted: fn(&Sensor) -> bool| {
            all.iter().enumerate().filter(|(_, sensor)| wanted(sensor)).map(|(i, _)| i).collect()
        };
        let own_clocks = indices(|sensor| sensor.own_clock.is_some());
        let ports = indices(|sensor| sensor.port.is_some());
        let reach = reach_of(&all);
        let sectors = all.iter().map(|sensor| sector_of(sensor, reach?)).collect();
        Self(Arc::new(Parts { all, own_clocks, ports, reach, sectors }))
    }
}

impl Deref for Sensors {
    type Target = [Sensor];

    fn deref(&self) -> &[Sensor] {
        &self.0.all
    }
}

/// The bytes that a device has on the heap: its rays, and its table.
fn device(device: &Device) -> usize {
    let table = if let Device::Infrared(Infrared { model: InfraredModel::Lookup(lookup), .. }) = device {
        lookup.heap_bytes()
    } else {
        0
    };
    device.fan().map_or(0, Fan::heap_bytes) + table
}

/// The range of sensors that look along few rays; `None` if collecting the shapes there once for all would not pay.
fn reach_of(sensors: &[Sensor]) -> Option<Reach> {
    let looks = sensors.iter().filter_map(|sensor| {
        let (mount, range_m) = (sensor.device.mount()?, sensor.device.range_m()?);
        let is_narrow = sensor.device.fan().is_some_and(|fan| fan.len() <= FEW_RAYS);
        let offset_m = mount.pose.position.coords.norm();
        is_narrow.then_some((mount.height.layer, offset_m + range_m))
    });
    let (layer, _) = looks.clone().next()?;
    let here = looks.filter(|(other, _)| *other == layer);
    let farthest_m = here.clone().map(|(_, reach_m)| reach_m).fold(0.0, f64::max);
    (here.count() > 1).then(|| Reach::new(farthest_m, layer))
}

fn sector_of(sensor: &Sensor, reach: Reach) -> Option<Sector> {
    let Device::Infrared(infrared) = &sensor.device else { return None };
    let Infrared { mount, fan, range_m, model, .. } = infrared;
    let InfraredModel::Phenomenological { .. } = model else { return None };
    let is_there = mount.turret.is_none() && mount.height.layer == reach.layer && fan.len() <= FEW_RAYS;
    is_there.then(|| Sector::new(&mount.pose, fan, *range_m))?
}

/// Sensors with more rays than this look for themselves.
const FEW_RAYS: usize = 16;

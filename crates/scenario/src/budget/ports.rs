//! Faster cables of sensors' own. Those that cannot carry what is measured are changed together, since each of them
//! alone is enough to be overloaded.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use super::change::{BAUDS, Change, Robot, faster};
use super::loads::port_share;
use super::plan::Plan;
use baudbot_sim::link::{Link, Uart};

impl Robot {
    /// Rates that are faster than each cable that carries too little.
    pub(super) fn port_bauds(&self) -> Vec<Change> {
        let ports = self.slow_ports();
        let fits = |baud: u32| ports.iter().all(|(_, uart)| faster(uart).any(|faster| faster == baud));
        BAUDS.into_iter().filter(|&baud| !ports.is_empty() && fits(baud)).map(Change::PortBauds).collect()
    }

    /// The sensors whose own cables carry too little.
    pub(super) fn slow_ports(&self) -> Vec<(usize, &Uart)> {
        let plan = Plan { spec: &self.spec, step_ns: self.step_ns, noise: false, measured: None };
        let slow = plan.ports().filter(|(_, sensor, clock, link)| port_share(sensor, clock, link) > 1.0);
        slow.filter_map(|(i, _, _, link)| if let Link::Uart(uart) = link { Some((i, uart)) } else { None })
            .collect()
    }

    pub(super) fn port_phrase(&self, baud: u32) -> String {
        let ports = self.slow_ports();
        let names: Vec<_> = ports.iter().map(|(i, _)| self.spec.sensors[*i].name.as_str()).collect();
        let s = if names.len() == 1 { "" } else { "s" };
        format!("{baud} baud on the port{s} of {}", names.join(", "))
    }

    pub(super) fn port_overrides(&self, baud: u32) -> Vec<String> {
        let name = |i: usize| self.spec.sensors[i].name.as_str();
        let one = |i| format!("robots.{}.sensors.{}.port.link.baud={baud}", self.spec.table_name(), name(i));
        self.slow_ports().into_iter().map(|(i, _)| one(i)).collect()
    }
}

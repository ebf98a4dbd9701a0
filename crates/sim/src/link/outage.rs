//! A cable that is pulled and put back. What would arrive in between is lost, both ways.

use crate::time::SimTime;

/// A time in which the cable is out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outage {
    /// The instant from which on the cable is out.
    pub from: SimTime,
    /// The instant until just before which the cable is out.
    pub until: SimTime,
}

/// Whether one of these outages, which are in their order and apart, covers the instant.
pub(super) fn covers(outages: &[Outage], at: SimTime) -> bool {
    let begun = outages.partition_point(|outage| outage.from <= at);
    begun.checked_sub(1).is_some_and(|last| at < outages[last].until)
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    #[test]
    fn an_outage_covers_its_first_instant_and_not_its_end() {
        let outage = |from, until| Outage { from: SimTime::from_ns(from), until: SimTime::from_ns(until) };
        let outages = [outage(10, 20), outage(20, 20), outage(30, 40)];
        let covered: Vec<u64> = (0..50).filter(|&ns| covers(&outages, SimTime::from_ns(ns))).collect();
        let expected: Vec<u64> = (10..20).chain(30..40).collect();
        assert_eq!(covered, expected);
        assert!(!covers(&[], SimTime::ZERO));
    }
}

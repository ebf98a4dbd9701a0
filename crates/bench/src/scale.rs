//! The counting of a workload's instructions.

/// Two numbers of ticks, and what is counted in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// The ticks of the two runs.
    pub(crate) ticks: [u64; 2],
    pub(crate) units_a_tick: f64,
    /// One of them.
    pub(crate) unit: &'static str,
}

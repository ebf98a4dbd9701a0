//! The cells of the floor that are covered.

use baudbot_proto::v1;

use crate::report::CoverageReport;

/// The cells of a world's floor; `None` if it counts no coverage.
pub(crate) fn coverage(report: &CoverageReport) -> Option<v1::GetCoverageResponse> {
    let rules = &report.scenario.rules;
    let (floor, coverage) = (rules.floor.as_ref()?, report.coverage.as_ref()?);
    let corner = floor.corner();
    Some(v1::GetCoverageResponse {
        tick: report.tick,
        cell_m: floor.cell_m(),
        x_m: corner.x,
        y_m: corner.y,
        columns: floor.columns() as u32,
        rows: floor.rows() as u32,
        free: floor.free_runs(),
        covered: coverage.covered_runs(floor),
        sensed: if rules.count_sensed() { coverage.sensed_runs(floor) } else { Vec::new() },
    })
}

//! The grid of a field that robots write to.

use alloc::format;

use baudbot_fields::number::{Coordinate, Length, NotNegative, Number, Positive};
use baudbot_fields::{FieldError, Path};
use baudbot_geometry::{Point, math};
use baudbot_sim::trail::TrailGrid;

type Result<T> = core::result::Result<T, FieldError>;

#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct RawTrail {
    /// Corner with the least x and y. Type: `[x, y]`.
    corner_m: [Number<Coordinate>; 2],
    /// Width and depth; the last cells may stand out. Type: `[x, y]`.
    size_m: [Number<Length>; 2],
    /// Side of a cell of the grid.
    #[serde(default = "trail_cell")]
    cell_m: Number<Length>,
    /// Time in which a trail fades to 1/e. Default: it stays.
    decay_s: Option<Number<Positive>>,
    /// Diffusion coefficient: a puff is √(2 D t) wide.
    #[serde(default)]
    diffusion_m2_s: Number<NotNegative>,
}

fn trail_cell() -> Number<Length> {
    Number::of(0.05)
}

/// Cells of trails, each as often as it is worked off in a tick.
pub(super) const MOST_CELLS: f64 = 1_048_576.0;

/// The grid of a trail, for which there must be room among the cells that a tick may work off.
pub(super) fn trail(path: &Path, raw: &RawTrail, step_ns: u64, room: &mut f64) -> Result<TrailGrid> {
    let cell_m = raw.cell_m.get();
    let [columns, rows] = raw.size_m.map(|size| math::ceil(size.get() / cell_m));
    let [x, y] = raw.corner_m.map(Number::get);
    let grid = TrailGrid {
        corner: Point::new(x, y),
        cell_m,
        cells: [columns as usize, rows as usize],
        decay_s: raw.decay_s.map(Number::get),
        diffusion_m2_s: raw.diffusion_m2_s.get(),
    };
    let steps = grid.steps(step_ns as f64 * 1e-9);
    *room -= columns * rows * steps.max(1.0);
    if *room >= 0.0 {
        return Ok(grid);
    }
    let problem = format!(
        "makes {columns} by {rows} cells, each {} times a tick; all trails together may have {MOST_CELLS}, so make cells larger or `diffusion_m2_s` smaller",
        steps.max(1.0)
    );
    Err(path.field("cell_m").error(problem))
}

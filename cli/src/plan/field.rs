//! The path of a point down a brain's potential field, with the field's contours: Figs. 6.12 and 6.13.

use std::process::ExitCode;

use baudbot_brains::catalogue;
use baudbot_brains::description::Description;
use baudbot_brains::potential::Descent;
use baudbot_brains::potential::behavior::Parameters;
use baudbot_geometry::{Bounds, Point};
use baudbot_plot::arena::{self, Route};
use baudbot_plot::quantity::count;
use baudbot_sim::Scenario;
use baudbot_sim::arena::Arena;
use serde::Serialize;

use super::{map, metres, place, show};
use crate::args::PlanArgs;
use crate::error::Refused;
use crate::text::pairs;

/// The result, for programs.
#[derive(Serialize)]
struct FieldResult {
    brain: String,
    potentials: usize,
    is_stuck: bool,
    length_m: f64,
    points_m: Vec<[f64; 2]>,
}

/// Follows the field, and shows the result.
pub(super) fn plan(
    args: &PlanArgs,
    brain: &str,
    from: Point,
    scenario: &Scenario,
    label: &str,
) -> anyhow::Result<ExitCode> {
    let parameters = parameters(brain)?;
    let descent = Descent::new(&parameters, from)
        .map_err(|error| Refused::error(format!("--field {brain}: {error}")))?;
    let (is_stuck, length_m) = (!descent.is_at_goal, descent.length_m());
    let end = descent.points.last().copied().unwrap_or(from);
    let potentials = 1 + parameters.obstacles.len() + parameters.waypoints.len();
    let path = match is_stuck {
        true => format!("locked at {} after {} m: no direction leads down", place(end), metres(length_m)),
        false => format!("{} m", metres(length_m)),
    };
    let words = pairs(
        "",
        &[
            ("field", format!("{brain}, {}", count(potentials, "potential"))),
            ("from", place(from)),
            ("to", place(parameters.goal.center())),
            ("path", path.clone()),
        ],
    );
    let about = format!("{brain}, {}", count(potentials, "potential"));
    let notes = vec![about, format!("the path: {path}")];
    let picture =
        || arena::draw_route(scenario, label, &route(&parameters, &descent, &scenario.arena, notes));
    let points_m = descent.points.iter().map(|point| [point.x, point.y]).collect();
    let found = FieldResult { brain: brain.to_owned(), potentials, is_stuck, length_m, points_m };
    show(args, picture, &found, &words, is_stuck)
}

/// The picture: contours, and the path.
fn route(parameters: &Parameters, descent: &Descent, arena: &Arena, notes: Vec<String>) -> Route {
    let bounds = map::bounds(arena).into_iter().chain(Bounds::of_points(&descent.points));
    let field = parameters.field(parameters.waypoints.first());
    let contours = |bounds: Bounds| arena::contours(&bounds, CONTOURS, |at| field.height(at));
    let contours = bounds.reduce(|a, b| a.union(&b)).map(contours).unwrap_or_default();
    Route { contours, path: descent.points.clone(), notes, ..Route::default() }
}

/// The field of a brain: that of its first behaviour which has one.
fn parameters(brain: &str) -> anyhow::Result<Parameters> {
    let refused = |problem: String| Refused::error(format!("--field {brain}: {problem}"));
    catalogue::check(brain).map_err(|error| refused(error.to_string()))?;
    let toml = catalogue::described(brain).map_err(|error| refused(error.to_string()))?;
    let toml =
        toml.ok_or_else(|| refused("the brain is written in Rust; a field is described in TOML".into()))?;
    let description = Description::parse(&toml).map_err(|error| refused(error.to_string()))?;
    let (name, table) = description.parameters_of("potential_field").next().ok_or_else(|| {
        refused("the brain has no behaviour of kind `potential_field`; `four-pillars` has one".into())
    })?;
    baudbot_fields::read(table.clone()).map_err(|error| refused(format!("motor.{name}.parameters.{error}")))
}

/// Heights at which contours are drawn.
const CONTOURS: u32 = 30;

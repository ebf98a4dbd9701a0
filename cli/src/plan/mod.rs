//! `baudbot plan`: a path through a scenario's arena by a method of Section 6.2.1, and the cells that the search examined.
//!
//! [`map`] makes cells of the arena as a brain would that knows its walls; [`planned_path`] finds a path through them, by
//! `baudbot_brains::planning`; [`arena`] shows both. [`graph`] does the same on nodes and edges; [`field`] follows a
//! point down a potential field of Section 6.2.2.

mod field;
mod graph;
mod map;
mod planned_path;

use std::process::ExitCode;

use baudbot_brains::planning::{Cell, End, Grid, GridError, PlanError};
use baudbot_geometry::{Bounds, Point};
use baudbot_plot::arena::{self, Route};
use baudbot_plot::quantity::{count, handy};
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use clap::ValueEnum;
use serde::Serialize;

use self::planned_path::PlannedPath;
use crate::args::{Method, PlanArgs};
use crate::error::Refused;
use crate::output_files::Inputs;
use crate::run::overrides;
use crate::scenarios::Source;
use crate::text::{self, pairs};

pub(crate) fn plan(args: &PlanArgs) -> anyhow::Result<ExitCode> {
    let svg = args.svg.iter().map(|path| ("--svg", path.as_path()));
    let inputs = Inputs::of(&args.scenario, &args.changes).brains(args.field.as_slice());
    args.graph.iter().fold(inputs, |all, path| all.file("graph", path)).check(svg)?;
    let source = Source::find(&args.scenario)?;
    let scenario = source.parse(&overrides(&args.changes)?)?;
    let robot = robot(args.robot.as_deref(), &scenario.robots)?;
    let from = args.from.unwrap_or(robot.start.pose.position);
    if let Some(brain) = &args.field {
        return field::plan(args, brain, from, &scenario, source.label());
    }
    let to = args.to.ok_or_else(|| Refused::error("--to: is missing; give it the goal"))?;
    if let Some(file) = &args.graph {
        return graph::of_file(args, file, [from, to])?.plan(&scenario, source.label());
    }
    let task = Task::new(args, &scenario, robot, [from, to])?;
    if let Some(spacing_m) = args.spacing_m {
        return graph::of_free_space(&task, spacing_m, scenario.seed)?.plan(&scenario, source.label());
    }
    let path =
        PlannedPath::find(&task.grid, args, task.from, task.to).map_err(|error| task.refusal(&error))?;
    let picture = || arena::draw_route(&scenario, source.label(), &task.route(&path));
    show(args, picture, &task.found(&path), &task.words(&path), path.is_stuck)
}

/// Shows a result as the arguments ask for it.
fn show(
    args: &PlanArgs,
    picture: impl FnOnce() -> String,
    found: &impl Serialize,
    words: &str,
    is_stuck: bool,
) -> anyhow::Result<ExitCode> {
    let code = if is_stuck { ExitCode::FAILURE } else { ExitCode::SUCCESS };
    if let Some(svg) = &args.svg {
        text::write(svg, &picture())?;
        if svg.as_os_str() == "-" {
            return Ok(code);
        }
    }
    if args.json {
        text::print_json(found)?;
    } else {
        text::print(words)?;
    }
    Ok(code)
}

/// The problem: the grid, its ends and the method.
struct Task<'a> {
    args: &'a PlanArgs,
    robot: &'a RobotSpec,
    grid: Grid,
    clearance_m: f64,
    from: Point,
    to: Point,
}

/// The result, for programs.
#[derive(Serialize)]
struct Found {
    method: String,
    robot: String,
    clearance_m: f64,
    cell_m: f64,
    columns: usize,
    rows: usize,
    free_cells: usize,
    cells_looked_at: usize,
    cells_expanded: usize,
    is_stuck: bool,
    length_m: f64,
    points_m: Vec<[f64; 2]>,
}

impl<'a> Task<'a> {
    fn new(
        args: &'a PlanArgs,
        scenario: &Scenario,
        robot: &'a RobotSpec,
        [from, to]: [Point; 2],
    ) -> anyhow::Result<Self> {
        if args.margin_m < 0.0 {
            return Err(Refused::error(format!("--margin-m: must be 0 or more, is {}", args.margin_m)));
        }
        if args.penalty < 0.0 {
            return Err(Refused::error(format!("--penalty: must be 0 or more, is {}", args.penalty)));
        }
        let clearance_m = robot.drive.radius_m + args.margin_m;
        let grid = map::grid(&scenario.arena, args.cell_m, clearance_m);
        let grid = grid.map_err(|error| {
            Refused::error(if error == GridError::NoWalls {
                "the scenario's arena has no walls: there is nothing to plan around".to_owned()
            } else {
                format!("--cell-m {}: {error}", args.cell_m)
            })
        })?;
        Ok(Self { args, robot, grid, clearance_m, from, to })
    }

    fn free_cells(&self) -> usize {
        self.grid.cells().filter(|&cell| self.grid.is_free(cell)).count()
    }

    /// In the words of the command line, why there is no path.
    fn refusal(&self, error: &PlanError) -> anyhow::Error {
        let end = |end: End| match end {
            End::Start if self.args.from.is_none() => ("--from (where the robot starts)", self.from),
            End::Start => ("--from", self.from),
            End::Target => ("--to", self.to),
        };
        let clearance = handy(self.clearance_m);
        Refused::error(match error {
            PlanError::OffMap { end: which, .. } | PlanError::Outside { end: which, .. } => {
                let (option, point) = end(*which);
                format!("{option}: {} is outside the arena; choose another place", place(point))
            }
            PlanError::Blocked { end: which, .. } => {
                let (option, point) = end(*which);
                format!(
                    "{option}: the cell at {} is in a wall or closer to one than {clearance} m, the radius of `{}` \
                     with its margin; choose another place, or a smaller --cell-m",
                    place(point),
                    self.robot.name
                )
            }
            PlanError::Unreachable { .. } | PlanError::DeadEnd { .. } => format!(
                "no path leads from {} to {}: walls separate them, or leave `{}` less than {clearance} m on either side; if \
                 there is a door, try a smaller --cell-m",
                place(self.from),
                place(self.to),
                self.robot.name
            ),
        })
    }

    fn found(&self, path: &PlannedPath) -> Found {
        Found {
            method: name(self.args.method),
            robot: self.robot.name.clone(),
            clearance_m: self.clearance_m,
            cell_m: self.grid.cell_m(),
            columns: self.grid.columns(),
            rows: self.grid.rows(),
            free_cells: self.free_cells(),
            cells_looked_at: path.touched.len(),
            cells_expanded: path.expanded,
            is_stuck: path.is_stuck,
            length_m: path.length_m,
            points_m: path.points.iter().map(|point| [point.x, point.y]).collect(),
        }
    }

    fn words(&self, path: &PlannedPath) -> String {
        let found = self.found(path);
        let grid = format!("{} by {} cells of {} m", found.columns, found.rows, handy(found.cell_m));
        let clear = format!("{}, {} m from walls", found.robot, handy(found.clearance_m));
        let end = path.points.last().copied().unwrap_or(self.from);
        let led = match path.is_stuck {
            true => format!("stuck at {}: all neighbours were visited", place(end)),
            false => format!("{} m, {}", metres(path.length_m), bends(&path.points)),
        };
        pairs(
            "",
            &[
                ("method", found.method),
                ("robot", clear),
                ("grid", format!("{grid}, {} free", found.free_cells)),
                ("from", place(self.from)),
                ("to", place(self.to)),
                ("looked at", self.effort(path)),
                ("path", led),
            ],
        )
    }

    fn effort(&self, path: &PlannedPath) -> String {
        match self.args.method {
            Method::Cells => {
                format!("{}, {} of them on the path", count(path.cells.len(), "convex cell"), path.expanded)
            }
            Method::Walker | Method::Greedy | Method::Dijkstra | Method::AStar | Method::ThetaStar => {
                format!("{}, {} expanded", count(path.touched.len(), "cell"), path.expanded)
            }
        }
    }

    /// The picture of it.
    fn route(&self, path: &PlannedPath) -> Route {
        let cell = |point| self.grid.cell_at(point).map(|cell| square(&self.grid, cell));
        let is_grid = self.args.method != Method::Cells;
        let mut notes = vec![format!("{}, cells of {} m", name(self.args.method), handy(self.grid.cell_m()))];
        notes.push(self.effort(path));
        notes.push(match path.is_stuck {
            true => "it got stuck where the path ends".to_owned(),
            false => format!("a path of {} m, {}", metres(path.length_m), bends(&path.points)),
        });
        Route {
            blocked: map::runs(&self.grid, |cell| !self.grid.is_free(cell)),
            looked_at: map::runs(&self.grid, |cell| path.touched.contains(&cell)),
            cells: path.cells.clone(),
            start: cell(self.from).filter(|_| is_grid),
            target: cell(self.to).filter(|_| is_grid),
            path: path.points.clone(),
            notes,
            ..Route::default()
        }
    }
}

/// The robot whose size counts.
fn robot<'a>(name: Option<&str>, robots: &'a [RobotSpec]) -> anyhow::Result<&'a RobotSpec> {
    let named = |robot: &&RobotSpec| name.is_none_or(|name| robot.name == name);
    robots.iter().find(named).ok_or_else(|| {
        let names = robots.iter().map(|robot| robot.name.as_str()).collect::<Vec<_>>().join(", ");
        Refused::error(match name {
            Some(name) => format!("--robot: there is no robot `{name}`; there are: {names}"),
            None => "the scenario has no robot to plan for; add one".to_owned(),
        })
    })
}

fn name(method: Method) -> String {
    method.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
}

fn bends(points: &[Point]) -> String {
    count(points.len().saturating_sub(2), "bend")
}

fn place(point: Point) -> String {
    format!("({}, {})", handy(point.x), handy(point.y))
}

fn square(grid: &Grid, cell: Cell) -> Bounds {
    Bounds { min: grid.corner(cell), max: grid.corner(cell.offset(1, 1)) }
}

/// The length to a tenth of a millimetre, so that lengths can be compared.
fn metres(length_m: f64) -> String {
    format!("{length_m:.4}")
}

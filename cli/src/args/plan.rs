//! The arguments of `baudbot plan`.

use std::path::PathBuf;

use baudbot_brains::planning::{Heuristic, Moves};
use baudbot_geometry::Point;
use clap::{Args, ValueEnum};

use super::value::ValueError;
use super::{ChangeArgs, finite};

#[derive(Debug, Args)]
pub(crate) struct PlanArgs {
    /// A scenario file, or a built-in scenario, such as wander or devices/laser (`baudbot list`)
    pub(crate) scenario: String,
    /// Goal of the path, in metres
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point, required_unless_present = "field")]
    pub(crate) to: Option<Point>,
    /// Start of the path, in metres [default: the robot's start]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = point)]
    pub(crate) from: Option<Point>,
    /// The planning method
    #[arg(long, value_name = "METHOD", default_value = "a-star")]
    pub(crate) method: Method,
    /// Moves between cells; ignored by theta-star and cells, which have their own
    #[arg(long, value_name = "STEPS", default_value = "8")]
    pub(crate) steps: Steps,
    /// Estimate of the remaining path, for walker, greedy and a-star
    #[arg(long, value_name = "HEURISTIC", default_value = "euclidean")]
    pub(crate) heuristic: Estimate,
    /// Penalty for each obstacle on the straight line to the goal, added to the estimate, in cells; a-star may then miss the shortest path
    #[arg(long, value_name = "CELLS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) penalty: f64,
    /// Side of a cell, in metres
    #[arg(long, value_name = "M", default_value_t = 0.1, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) cell_m: f64,
    /// Clearance between the robot's rim and walls, in metres
    #[arg(long, value_name = "M", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) margin_m: f64,
    /// Plan on the nodes and edges of this TOML or JSON file, in place of square cells, from the node nearest to the start to the one nearest to the goal
    #[arg(long, value_name = "FILE", conflicts_with_all = ["spacing_m", "steps", "penalty", "cell_m", "margin_m"])]
    pub(crate) graph: Option<PathBuf>,
    /// Plan on nodes that are at least so far apart, in metres, drawn from the free cells by the seed; edges join neighbours that see each other
    #[arg(long, value_name = "M", conflicts_with_all = ["steps", "penalty"], value_parser = finite)]
    pub(crate) spacing_m: Option<f64>,
    /// Follow a point down the potential field of this brain, with its goal; the picture has the field's contours
    #[arg(long, value_name = "BRAIN", conflicts_with_all = ["to", "method", "heuristic", "graph", "spacing_m", "steps", "penalty", "cell_m", "margin_m"])]
    pub(crate) field: Option<String>,
    /// The robot to plan for [default: the first]
    #[arg(long, value_name = "ROBOT")]
    pub(crate) robot: Option<String>,
    /// Draw the examined cells and the path as an SVG picture; `-` is stdout, without other output
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Write the result as one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) changes: ChangeArgs,
}

/// The method by which a path is planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Always to the neighbour nearest to the goal, and never back: Fig. 6.7 of the lecture notes, as printed
    Walker,
    /// Best-first search with a list of open cells: quick, but not the shortest path
    Greedy,
    /// Dijkstra's algorithm: the shortest path, Fig. 6.9
    Dijkstra,
    /// A*: the shortest path, with fewer cells examined
    AStar,
    /// Theta*: a path with turns by any angle
    ThetaStar,
    /// Large convex cells, crossed in straight lines: Fig. 6.6
    Cells,
}

/// Steps from cell to cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Steps {
    /// Along rows and columns
    #[value(name = "4")]
    Four,
    /// Also diagonally, without cutting corners
    #[value(name = "8")]
    Eight,
    /// Also diagonally, past any corner
    #[value(name = "8-cut")]
    EightCut,
}

/// Estimate of the remaining path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Estimate {
    /// The straight line
    Euclidean,
    /// Diagonal steps, then straight ones
    Octile,
    /// Steps along rows and columns; an overestimate if diagonal steps are allowed
    Manhattan,
}

impl From<Steps> for Moves {
    fn from(steps: Steps) -> Self {
        match steps {
            Steps::Four => Self::Four,
            Steps::Eight => Self::EightNoCut,
            Steps::EightCut => Self::Eight,
        }
    }
}

impl From<Estimate> for Heuristic {
    fn from(estimate: Estimate) -> Self {
        match estimate {
            Estimate::Euclidean => Self::Euclidean,
            Estimate::Octile => Self::Octile,
            Estimate::Manhattan => Self::Manhattan,
        }
    }
}

fn point(text: &str) -> Result<Point, ValueError> {
    let numbers = text.split_once(',').map(|(x, y)| (finite(x.trim()), finite(y.trim())));
    match numbers {
        Some((Ok(x), Ok(y))) => Ok(Point::new(x, y)),
        _ => Err(ValueError::Example {
            form: "two numbers with a comma between them, such as 1.5,-2",
            text: text.to_owned(),
        }),
    }
}

pub(super) const EXAMPLES: &str = "\
Examples:
  baudbot plan wander --to 1.4,1.4               the length of the path, and the cells examined
  baudbot plan explore-office --to 11,8 --method cells --svg way.svg
  baudbot plan grid-wall --to 17.5,10.5 --cell-m 1 --method walker --svg -
  baudbot plan explore-office --to 11,8 --spacing-m 0.8 --method dijkstra --svg way.svg
  baudbot plan my.toml --to 3,2 --graph nodes.toml
  baudbot plan four-pillars --field four-pillars --svg field.svg
  baudbot plan my.toml --from 1,1 --to 3,2 --cell-m 0.05 --margin-m 0.1 --json

The map contains the stationary things in the arena, at any height; moving things are not in it. A cell is free if all of it
is farther from every wall than the robot's radius plus the margin. A file for --graph has nodes = [{ x_m = 0.5, y_m = 1.0 }, ...] and edges = [[0, 1], ...], which count the nodes from 0; it is not
held against the walls. The exit code is 1 if the walker gets stuck, or the point on a field.";

//! Paths over nodes and edges, the left panel of Fig. 6.5: those of a file, or drawn from the free cells of the arena.

use std::path::Path;
use std::process::ExitCode;

use baudbot_brains::planning::{End, NodeGraph, NodeGraphError, NodePlan, NodePlanError, PlanError};
use baudbot_geometry::Point;
use baudbot_plot::arena::{self, Route};
use baudbot_plot::quantity::{count, handy};
use baudbot_sim::Scenario;
use serde::{Deserialize, Serialize};
use toml::Table;

use super::{Task, bends, map, metres, name, place, show};
use crate::args::{Method, PlanArgs};
use crate::error::Refused;
use crate::text::pairs;

/// The problem: a graph, its ends and the method.
pub(super) struct GraphTask<'a> {
    args: &'a PlanArgs,
    graph: NodeGraph,
    /// The cells from which it was drawn.
    drawn: Option<&'a Task<'a>>,
    start: usize,
    target: usize,
}

/// A file with a graph.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GraphFile {
    nodes: Vec<Node>,
    #[serde(default)]
    edges: Vec<[usize; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Node {
    x_m: f64,
    y_m: f64,
}

/// The result, for programs.
#[derive(Serialize)]
struct GraphResult {
    method: String,
    nodes: usize,
    edges: usize,
    start_node: usize,
    target_node: usize,
    nodes_looked_at: usize,
    nodes_expanded: usize,
    is_stuck: bool,
    length_m: f64,
    path: Vec<usize>,
    points_m: Vec<[f64; 2]>,
}

/// The graph of a file.
pub(super) fn of_file<'a>(
    args: &'a PlanArgs,
    file: &Path,
    [from, to]: [Point; 2],
) -> anyhow::Result<GraphTask<'a>> {
    let refused = |problem: String| Refused::error(format!("{}: {problem}", file.display()));
    let text = std::fs::read_to_string(file).map_err(|error| refused(error.to_string()))?;
    let is_json = file.extension().is_some_and(|extension| extension == "json");
    let table: Table = match is_json {
        true => serde_json::from_str(&text).map_err(|error| refused(error.to_string()))?,
        false => text.parse().map_err(|error: toml::de::Error| {
            let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            refused(format!("line {}: {}", before.matches('\n').count() + 1, error.message()))
        })?,
    };
    let read: GraphFile = baudbot_fields::read(table).map_err(|error| refused(error.to_string()))?;
    let nodes = read.nodes.iter().map(|node| Point::new(node.x_m, node.y_m)).collect();
    let graph = NodeGraph::new(nodes, read.edges).map_err(|error| refused(in_file(&error)))?;
    let (start, target) = (graph.nearest(from), graph.nearest(to));
    if start == target && from != to {
        return Err(refused(format!(
            "node {start} is the nearest to both ends; give the graph nodes near them"
        )));
    }
    Ok(GraphTask { args, graph, drawn: None, start, target })
}

/// The error with the field of the file.
fn in_file(error: &NodeGraphError) -> String {
    match error {
        NodeGraphError::Size { .. } => format!("nodes: {error}"),
        NodeGraphError::Place { node } => format!("nodes[{node}]: x_m and y_m must be finite numbers"),
        NodeGraphError::NoNode { edge, node, nodes } => {
            format!("edges[{edge}]: there is no node {node}; there are {nodes}, counted from 0")
        }
        NodeGraphError::Loop { edge, node } => {
            format!("edges[{edge}]: leads from node {node} to itself; give it another end, or leave it out")
        }
        NodeGraphError::Twice { edge } => {
            format!("edges[{edge}]: joins the same nodes as an edge before it; leave it out")
        }
        NodeGraphError::Spacing { .. } => error.to_string(),
    }
}

/// A graph of free cells.
pub(super) fn of_free_space<'a>(
    task: &'a Task<'a>,
    spacing_m: f64,
    seed: u64,
) -> anyhow::Result<GraphTask<'a>> {
    if spacing_m <= 0.0 {
        return Err(Refused::error(format!("--spacing-m: must be positive, is {spacing_m}")));
    }
    let cell = |end, point| {
        let cell = task.grid.cell_at(point).ok_or(PlanError::OffMap { end, point })?;
        if task.grid.is_free(cell) { Ok(cell) } else { Err(PlanError::Blocked { end, cell }) }
    };
    let ends = cell(End::Start, task.from).and_then(|start| Ok([start, cell(End::Target, task.to)?]));
    let ends = ends.map_err(|error| task.refusal(&error))?;
    let graph = NodeGraph::scattered(&task.grid, &ends, spacing_m, seed)
        .map_err(|error| Refused::error(format!("--spacing-m: {error}")))?;
    let target = graph.nearest(task.grid.center(ends[1]));
    Ok(GraphTask { args: task.args, graph, drawn: Some(task), start: 0, target })
}

impl GraphTask<'_> {
    /// Plans, and shows the result.
    pub(super) fn plan(&self, scenario: &Scenario, label: &str) -> anyhow::Result<ExitCode> {
        let (graph, heuristic) = (&self.graph, self.args.heuristic.into());
        let plan = match self.args.method {
            Method::Walker => graph.walk(self.start, self.target, heuristic),
            Method::Greedy => graph.greedy(self.start, self.target, heuristic),
            Method::Dijkstra => graph.dijkstra(self.start, self.target),
            Method::AStar => graph.a_star(self.start, self.target, heuristic),
            Method::ThetaStar | Method::Cells => {
                let text = "needs cells; on nodes take walker, greedy, dijkstra or a-star";
                return Err(Refused::error(format!("--method: {} {text}", name(self.args.method))));
            }
        };
        let (plan, is_stuck) = match plan {
            Ok(plan) => (plan, false),
            Err(NodePlanError::DeadEnd { walked }) => (walked, true),
            Err(error @ (NodePlanError::Unreachable { .. } | NodePlanError::NoNode { .. })) => {
                let remedy = match self.drawn {
                    Some(_) => "try a smaller --spacing-m, a smaller --cell-m or another --seed",
                    None => "add edges to the file",
                };
                return Err(Refused::error(format!("{error}; {remedy}")));
            }
        };
        let points: Vec<_> = plan.nodes.iter().map(|&node| graph.nodes()[node]).collect();
        let picture = || arena::draw_route(scenario, label, &self.route(&plan, &points, is_stuck));
        let words = self.words(&plan, &points, is_stuck);
        show(self.args, picture, &self.found(&plan, &points, is_stuck), &words, is_stuck)
    }

    fn found(&self, plan: &NodePlan, points: &[Point], is_stuck: bool) -> GraphResult {
        GraphResult {
            method: name(self.args.method),
            nodes: self.graph.nodes().len(),
            edges: self.graph.edges().len(),
            start_node: self.start,
            target_node: self.target,
            nodes_looked_at: plan.touched.len(),
            nodes_expanded: plan.expanded.len(),
            is_stuck,
            length_m: plan.length_m,
            path: plan.nodes.clone(),
            points_m: points.iter().map(|point| [point.x, point.y]).collect(),
        }
    }

    fn words(&self, plan: &NodePlan, points: &[Point], is_stuck: bool) -> String {
        let end = |node: usize| format!("node {node} at {}", place(self.graph.nodes()[node]));
        pairs(
            "",
            &[
                ("method", name(self.args.method)),
                ("graph", self.size()),
                ("from", end(self.start)),
                ("to", end(self.target)),
                ("looked at", effort(plan)),
                ("path", self.way(plan, points, is_stuck)),
            ],
        )
    }

    fn size(&self) -> String {
        let (nodes, edges) = (self.graph.nodes().len(), self.graph.edges().len());
        let drawn = self.drawn.map(|task| format!(", drawn from cells of {} m", handy(task.grid.cell_m())));
        format!("{}, {}{}", count(nodes, "node"), count(edges, "edge"), drawn.unwrap_or_default())
    }

    fn way(&self, plan: &NodePlan, points: &[Point], is_stuck: bool) -> String {
        match points.last() {
            Some(&end) if is_stuck => format!("stuck at {}: all neighbours were visited", place(end)),
            _ => format!("{} m, {}", metres(plan.length_m), bends(points)),
        }
    }

    fn route(&self, plan: &NodePlan, points: &[Point], is_stuck: bool) -> Route {
        let at = |node: usize| self.graph.nodes()[node];
        let method = format!("{}, {}", name(self.args.method), self.size());
        let path = format!("the path: {}", self.way(plan, points, is_stuck));
        let blocked = self.drawn.map(|task| map::runs(&task.grid, |cell| !task.grid.is_free(cell)));
        Route {
            blocked: blocked.unwrap_or_default(),
            nodes: self.graph.nodes().to_vec(),
            edges: self.graph.edges().iter().map(|edge| edge.map(at)).collect(),
            nodes_looked_at: plan.touched.iter().map(|&node| at(node)).collect(),
            path: points.to_vec(),
            notes: vec![method, effort(plan), path],
            ..Route::default()
        }
    }
}

fn effort(plan: &NodePlan) -> String {
    format!("{}, {} expanded", count(plan.touched.len(), "node"), plan.expanded.len())
}

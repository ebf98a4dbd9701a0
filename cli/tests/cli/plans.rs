//! `baudbot plan`.

use std::fs;

use crate::cli::{baudbot, good, place};

const WALL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/grid-wall.toml");
const TRAP: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../catalogue/scenarios/grid-trap.toml");

/// The report of a way across one of the two grids, after its arguments.
fn across(grid: &str, more: &[&str]) -> String {
    let args = [&["plan", grid, "--to", "17.5,10.5", "--cell-m", "1"], more].concat();
    good(&args)
}

/// The lengths are those that were computed independently for the grids of `brains/tests/data`, and so are the counts of
/// expanded cells: the scenarios have the same walls in the same cells, with a border around them.
#[test]
fn lengths_and_counts_are_those_of_the_grids() {
    for (grid, method, steps, effort, way) in [
        (WALL, "walker", "8", None, "35.7279 m, "),
        (WALL, "walker", "8-cut", None, "34.5563 m, "),
        (WALL, "greedy", "8", Some(46), "24.8995 m, "),
        (WALL, "dijkstra", "8", Some(367), "21.3848 m, "),
        (WALL, "dijkstra", "4", Some(373), "29.0000 m, "),
        (WALL, "a-star", "8", Some(135), "21.3848 m, "),
        (WALL, "theta-star", "8", None, "20.8497 m, 2 bends"),
        (TRAP, "walker", "8", None, "49.1421 m, "),
        (TRAP, "greedy", "4", Some(79), "25.0000 m, "),
        (TRAP, "dijkstra", "8", Some(350), "20.8995 m, "),
        (TRAP, "theta-star", "8", None, "20.2341 m, 2 bends"),
    ] {
        let said = across(grid, &["--method", method, "--steps", steps]);
        assert!(said.contains(&format!("path       {way}")), "{method} {steps}: {said}");
        let expanded = effort.map_or(String::new(), |cells| format!(" cells, {cells} expanded\n"));
        assert!(said.contains(&expanded), "{method} {steps}: {said}");
    }
    assert!(across(WALL, &["--heuristic", "octile"]).contains(" cells, 119 expanded\n"));
    assert!(across(WALL, &["--steps", "4", "--heuristic", "manhattan"]).contains(" cells, 140 expanded\n"));
}

#[test]
fn a_way_through_convex_cells_is_not_longer_than_one_in_eight_directions() {
    let length = |method: &str| {
        let json = across(WALL, &["--method", method, "--json"]);
        let found: serde_json::Value = serde_json::from_str(&json).unwrap();
        let points = found["points_m"].as_array().unwrap();
        let at = |i: usize| [points[i][0].as_f64().unwrap(), points[i][1].as_f64().unwrap()];
        assert_eq!((at(0), at(points.len() - 1)), ([2.5, 10.5], [17.5, 10.5]));
        let legs = (1..points.len()).map(|i| (at(i)[0] - at(i - 1)[0]).hypot(at(i)[1] - at(i - 1)[1]));
        let length = found["length_m"].as_f64().unwrap();
        assert!((legs.sum::<f64>() - length).abs() < 1e-9, "{json}");
        length
    };
    let (cells, shortest) = (length("cells"), length("dijkstra"));
    assert!(cells < shortest && cells > 15.0, "{cells} {shortest}");
}

#[test]
fn a_picture_shows_what_was_looked_at_and_the_way() {
    let path = place("way.svg");
    let said = across(TRAP, &["--svg", path.to_str().unwrap()]);
    assert_eq!(said, across(TRAP, &[]));
    let picture = fs::read_to_string(&path).unwrap();
    let text = roxmltree::Document::parse(&picture).unwrap();
    let class = |class: &str| {
        let mut all = text.descendants().filter(|node| node.attribute("class") == Some(class));
        all.next().and_then(|node| node.attribute("d")).unwrap_or_default().to_owned()
    };
    // Rows of the touched cells; a corner and two or more points.
    assert!(class("looked-at").matches('M').count() > 10, "{picture}");
    assert!(class("way").matches('L').count() > 2 && class("cells").is_empty(), "{picture}");
    assert_eq!(across(TRAP, &["--svg", "-"]), picture);
    let cells = across(TRAP, &["--svg", "-", "--method", "cells"]);
    assert!(cells.contains("5 convex cells, 3 of them on the path"), "{cells}");
}

/// A corridor that draws the walker in, and from which it never comes back.
#[test]
fn a_walker_that_gets_stuck_says_where_and_ends_with_1() {
    let path = place("corridor.toml");
    let body = "{ radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }";
    let corridor = format!(
        "[[arena.polygons]]\nname = \"border\"\nsolid = false\npoints_m = [[0, 0], [8, 0], [8, 6], [0, 6]]\n\
         [[arena.polygons]]\nname = \"corridor\"\nsolid = false\nclosed = false\n\
         points_m = [[3.5, 3.5], [5.5, 3.5], [5.5, 1.5], [3.5, 1.5]]\n\
         [[robots]]\nname = \"bob\"\nstart = {{ x_m = 1.5, y_m = 2.5 }}\nbody = {body}\n"
    );
    fs::write(&path, corridor).unwrap();
    let path = path.to_str().unwrap();
    let way = |method| {
        baudbot(&["plan", path, "--to", "6.5,2.5", "--cell-m", "1", "--steps", "4", "--method", method])
    };
    let (code, out, err) = way("walker");
    assert_eq!((code, err.as_str()), (1, ""), "{out}");
    assert!(out.contains("path       stuck at (4.5, 2.5): all neighbours were visited\n"), "{out}");
    let (code, out, _) = way("greedy");
    assert_eq!(code, 0, "{out}");
}

/// Two ways round the wall, over a node below it and one above it. The shorter one is √(8² + 7.5²) + √(7² + 7.5²) m long.
const NODES: &str = r#"
    nodes = [{ x_m = 2.5, y_m = 10.5 }, { x_m = 10.5, y_m = 2.0 }, { x_m = 10.5, y_m = 18.0 }, { x_m = 17.5, y_m = 10.5 }]
    edges = [[0, 1], [1, 3], [0, 2], [2, 3]]
"#;

#[test]
fn a_path_leads_over_the_nodes_of_a_file() {
    let toml = place("nodes.toml");
    fs::write(&toml, NODES).unwrap();
    let json = place("nodes.json");
    let nodes = "[{\"x_m\":2.5,\"y_m\":10.5},{\"x_m\":10.5,\"y_m\":2},{\"x_m\":10.5,\"y_m\":18},{\"x_m\":17.5,\"y_m\":10.5}]";
    fs::write(&json, format!("{{\"nodes\":{nodes},\"edges\":[[0,1],[1,3],[0,2],[2,3]]}}")).unwrap();
    for file in [&toml, &json] {
        for method in ["dijkstra", "a-star"] {
            let args = ["plan", WALL, "--to", "17,10", "--method", method, "--graph", file.to_str().unwrap()];
            let said = good(&args);
            assert!(said.contains("graph      4 nodes, 4 edges\n"), "{said}");
            assert!(said.contains("to         node 3 at (17.5, 10.5)\n"), "{said}");
            assert!(said.contains("path       21.2250 m, 1 bend\n"), "{said}");
        }
    }
    let toml = toml.to_str().unwrap();
    let args = ["plan", WALL, "--to", "17,10", "--graph", toml, "--json", "--method", "greedy"];
    let found: serde_json::Value = serde_json::from_str(&good(&args)).unwrap();
    assert_eq!(found["path"], serde_json::json!([0, 2, 3]), "{found}");
}

#[test]
fn a_path_leads_over_nodes_that_a_seed_draws_from_free_space() {
    let plan = |more: &[&str]| {
        let args =
            [&["plan", WALL, "--to", "17.5,10.5", "--cell-m", "0.5", "--spacing-m", "2"], more].concat();
        good(&args)
    };
    let found = |more: &[&str]| -> serde_json::Value {
        serde_json::from_str(&plan(&[more, &["--json"]].concat())).unwrap()
    };
    let (shortest, sooner) = (found(&["--method", "dijkstra"]), found(&[]));
    assert_eq!(shortest["length_m"], sooner["length_m"]);
    assert!(sooner["nodes_expanded"].as_u64() < shortest["nodes_expanded"].as_u64(), "{sooner}");
    // Theta* needs 20.85 m on cells of a metre.
    let length_m = shortest["length_m"].as_f64().unwrap();
    assert!((20.0..26.0).contains(&length_m), "{length_m}");
    assert_eq!(found(&[]), sooner);
    assert_ne!(found(&["--seed", "5"])["points_m"], sooner["points_m"]);
    let picture = plan(&["--svg", "-"]);
    let text = roxmltree::Document::parse(&picture).unwrap();
    let edges = text.descendants().find(|node| node.attribute("class") == Some("edges")).unwrap();
    let lines = edges.attribute("d").unwrap().matches('M').count() as u64;
    assert_eq!(Some(lines), sooner["edges"].as_u64());
}

#[test]
fn what_is_no_graph_is_refused_with_its_field() {
    let path = place("no-graph.toml");
    let refusal = |text: &str, more: &[&str]| {
        fs::write(&path, text).unwrap();
        let file = path.to_str().unwrap();
        let (code, out, err) = baudbot(&[&["plan", WALL, "--to", "17,10", "--graph", file], more].concat());
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        err.strip_prefix(&format!("error: {file}: ")).map_or_else(|| err.clone(), str::to_owned)
    };
    assert_eq!(refusal("nodes = [{ x_m = 1 }]", &[]), "nodes[0]: missing field `y_m`\n");
    assert_eq!(refusal("nodes = []", &[]), "nodes: a graph has 1 to 1048576 nodes, not 0\n");
    let edge = "nodes = [{ x_m = 1, y_m = 2 }]\nedges = [[0, 4]]";
    assert_eq!(refusal(edge, &[]), "edges[0]: there is no node 4; there are 1, counted from 0\n");
    assert!(
        refusal("nodes = [{ x_m = inf, y_m = 2 }]", &[]).starts_with("nodes[0]: x_m and y_m must be finite")
    );
    assert!(refusal("\nnodes = [", &[]).starts_with("line 2: "), "{}", refusal("\nnodes = [", &[]));
    let parted = refusal(&NODES.replace("[0, 1], [1, 3], [0, 2], [2, 3]", "[0, 1]"), &[]);
    assert_eq!(parted, "error: no path leads from node 0 to node 3; add edges to the file\n");
    let method = refusal(NODES, &["--method", "theta-star"]);
    assert!(method.starts_with("error: --method: theta-star needs cells; on nodes take walker"), "{method}");
    assert!(refusal(NODES, &["--penalty", "2"]).contains("cannot be used with"));
    let (code, _, err) = baudbot(&["plan", WALL, "--to", "17,10", "--spacing-m", "0"]);
    assert_eq!((code, err.as_str()), (2, "error: --spacing-m: must be positive, is 0\n"));
    let (_, _, err) = baudbot(&["plan", WALL, "--to", "17,10", "--spacing-m", "0.1"]);
    assert!(err.starts_with("error: --spacing-m: a spacing of 0.1 m makes more than 1000 nodes"), "{err}");
}

#[test]
fn what_cannot_be_is_refused_with_its_option() {
    let refusal = |args: &[&str]| {
        let (code, out, err) = baudbot(&[&["plan", WALL], args].concat());
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        err
    };
    let wall = refusal(&["--to", "10.5,10.5"]);
    assert!(
        wall.starts_with("error: --to: the cell at (10.5, 10.5) is in a wall or closer to one than 0.1 m"),
        "{wall}"
    );
    let from = refusal(&["--from", "10.5,10.5", "--to", "1,1"]);
    assert!(from.starts_with("error: --from: the cell at (10.5, 10.5) is in a wall"), "{from}");
    let outside = refusal(&["--to", "50,-3"]);
    assert_eq!(outside, "error: --to: (50, -3) is outside the arena; choose another place\n");
    let parted = refusal(&["--to", "17.5,10.5", "--margin-m", "2.4"]);
    assert!(
        parted.starts_with("error: no path leads from (2.5, 10.5) to (17.5, 10.5): walls separate them"),
        "{parted}"
    );
    let method = refusal(&["--to", "1,1", "--method", "magic"]);
    assert!(method.contains("walker, greedy, dijkstra, a-star, theta-star, cells"), "{method}");
    assert!(refusal(&["--to", "1"]).contains("must be two numbers with a comma between them"));
    assert!(refusal(&["--to", "1,1", "--cell-m", "0"]).contains("cell_m must be positive, not 0"));
    assert!(refusal(&["--to", "1,1", "--margin-m", "-1"]).contains("--margin-m: must be 0 or more, is -1"));
    assert!(
        refusal(&["--to", "1,1", "--robot", "eve"]).contains("there is no robot `eve`; there are: robot")
    );
}

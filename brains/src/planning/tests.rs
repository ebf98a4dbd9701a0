//! The searches on three known grids, and against each other on random ones.

use proptest::prelude::*;

use super::*;

const EMPTY: &str = include_str!("../../tests/data/grid-empty.txt");
const WALL: &str = include_str!("../../tests/data/grid-wall.txt");
const TRAP: &str = include_str!("../../tests/data/grid-trap.txt");

use Heuristic::{Euclidean, Manhattan, Octile};
use Moves::{Eight, EightNoCut, Four};

/// A grid with its ends.
#[derive(Debug)]
struct Task {
    grid: Grid,
    start: Cell,
    target: Cell,
}

impl Task {
    fn new(text: &str) -> Self {
        let Sketch { grid, start, target } = Grid::from_text(text).unwrap();
        Self { grid, start: start.unwrap(), target: target.unwrap() }
    }

    fn dijkstra(&self, moves: Moves) -> Plan {
        dijkstra(&self.grid, self.start, self.target, moves).unwrap()
    }

    fn a_star(&self, moves: Moves, heuristic: Heuristic) -> Plan {
        a_star(&self.grid, self.start, self.target, moves, heuristic).unwrap()
    }

    fn greedy(&self, moves: Moves) -> Plan {
        greedy(&self.grid, self.start, self.target, moves, Euclidean).unwrap()
    }

    fn walk(&self, moves: Moves) -> Plan {
        walk(&self.grid, self.start, self.target, moves, Euclidean).unwrap()
    }

    /// A plan leads from start to target by allowed moves, and has the stated length.
    fn check(&self, plan: &Plan, moves: Moves) {
        assert_eq!((plan.cells[0], plan.cells[plan.cells.len() - 1]), (self.start, self.target));
        let steps = plan.cells.windows(2).map(|pair| {
            let step = moves.neighbours(&self.grid, pair[0]).find(|(cell, _)| *cell == pair[1]);
            step.unwrap_or_else(|| panic!("{pair:?} is no move")).1
        });
        let length: f64 = steps.sum();
        assert!((length - plan.length_m).abs() < 1e-9, "{length} {}", plan.length_m);
    }
}

/// The figures are given to four places.
fn near(plan: &Plan, figure: f64) {
    assert!((plan.length_m - figure).abs() < 5.1e-5, "{} instead of {figure}", plan.length_m);
}

/// Lengths of the shortest path, of greedy search and of Fig. 6.7's walk, which were computed independently.
/// The searches of §6.2.1, Figs. 6.7 and 6.9.
#[test]
fn lengths_on_three_grids_are_the_known_ones() {
    let figures = [
        (EMPTY, Four, [27.0, 27.0, 27.0]),
        (EMPTY, EightNoCut, [19.9706, 19.9706, 19.9706]),
        (WALL, Four, [29.0, 29.0, 29.0]),
        (WALL, EightNoCut, [21.3848, 24.8995, 35.7279]),
        (WALL, Eight, [20.7990, 23.7279, 34.5563]),
        (TRAP, Four, [25.0, 25.0, 49.0]),
        (TRAP, EightNoCut, [20.8995, 22.0711, 49.1421]),
    ];
    for (text, moves, [shortest, greedy, walk]) in figures {
        let task = Task::new(text);
        let plans =
            [task.dijkstra(moves), task.a_star(moves, Euclidean), task.greedy(moves), task.walk(moves)];
        near(&plans[0], shortest);
        near(&plans[1], shortest);
        near(&plans[2], greedy);
        near(&plans[3], walk);
        plans.iter().for_each(|plan| task.check(plan, moves));
    }
}

#[test]
fn theta_star_goes_straight_and_round_corners() {
    for (text, figure, turns) in [(EMPTY, 19.2094, 0), (WALL, 20.8497, 2), (TRAP, 20.2341, 2)] {
        let task = Task::new(text);
        let plan = theta_star(&task.grid, task.start, task.target).unwrap();
        near(&plan, figure);
        assert_eq!(plan.cells.len() - 2, turns, "{:?}", plan.cells);
        let wheels: Vec<_> =
            plan.points(&task.grid).windows(2).map(|pair| (pair[1] - pair[0]).norm()).collect();
        assert!((wheels.iter().sum::<f64>() - plan.length_m).abs() < 1e-12);
        assert!(plan.cells.windows(2).all(|pair| line_of_sight(&task.grid, pair[0], pair[1])));
    }
}

/// With the tie rule of `best_first` and the order of `Moves::neighbours`, these are exact. A\* is better the
/// nearer its estimates are to the truth.
/// The cells that were checked, light green in Figs. 6.8 and 6.10.
#[test]
fn a_better_heuristic_expands_fewer_cells() {
    let figures = [
        (EMPTY, [372, 57, 45], [375, 28]),
        (WALL, [367, 135, 119], [373, 140]),
        (TRAP, [350, 127, 111], [358, 114]),
    ];
    for (text, eight, four) in figures {
        let task = Task::new(text);
        let plans =
            [task.dijkstra(EightNoCut), task.a_star(EightNoCut, Euclidean), task.a_star(EightNoCut, Octile)];
        assert_eq!(plans.each_ref().map(|plan| plan.expanded.len()), eight);
        assert!(eight[2] <= eight[1] && eight[1] <= eight[0]);
        let plans = [task.dijkstra(Four), task.a_star(Four, Manhattan)];
        assert_eq!(plans.each_ref().map(|plan| plan.expanded.len()), four);
    }
    let greedy = |text, moves| Task::new(text).greedy(moves).expanded.len();
    assert_eq!([greedy(EMPTY, Four), greedy(WALL, Four), greedy(TRAP, Four)], [28, 52, 79]);
    assert_eq!([greedy(EMPTY, EightNoCut), greedy(WALL, EightNoCut), greedy(TRAP, EightNoCut)], [16, 46, 75]);
}

#[test]
fn all_that_was_expanded_was_touched_once_and_the_target_came_last() {
    let task = Task::new(WALL);
    let theta = theta_star(&task.grid, task.start, task.target).unwrap();
    for plan in [task.dijkstra(EightNoCut), task.greedy(EightNoCut), task.walk(EightNoCut), theta] {
        let mut touched = vec![false; task.grid.len()];
        for &cell in &plan.touched {
            assert!(!std::mem::replace(&mut touched[task.grid.number(cell)], true), "{cell:?} twice");
        }
        assert!(plan.expanded.iter().all(|&cell| touched[task.grid.number(cell)]));
        assert_eq!(plan.expanded.last(), Some(&task.target));
    }
}

/// The end of Fig. 6.7 in front of a wall.
#[test]
fn the_walker_gets_stuck_where_a_search_does_not() {
    // The corridor draws it in, and it never goes back.
    let task = Task::new("..###.\nS...#T\n..###.\n......");
    let stuck = walk(&task.grid, task.start, task.target, Four, Euclidean);
    let walked: Vec<_> = (0..4).map(|column| Cell { column, row: 1 }).collect();
    // The start and its three neighbours, then those of each cell of the path that are new.
    let touched = [(0, 1), (1, 1), (0, 2), (0, 0), (2, 1), (1, 2), (1, 0), (3, 1)];
    let touched = touched.map(|(column, row)| Cell { column, row }).to_vec();
    assert_eq!(stuck, Err(PlanError::DeadEnd { cell: walked[3], moves: 3, walked, touched }));
    assert_eq!([task.dijkstra(Four).length_m, task.greedy(Four).length_m], [9.0, 9.0]);
}

/// The right panel of Fig. 6.5.
#[test]
fn a_cell_is_as_long_as_it_says() {
    let mut grid = Grid::new(3, 1, 0.25, baudbot_geometry::Point::new(7.0, -1.0)).unwrap();
    let (start, target) = (Cell { column: 0, row: 0 }, Cell { column: 2, row: 0 });
    let plans = |grid: &Grid| {
        [
            dijkstra(grid, start, target, Four),
            a_star(grid, start, target, Four, Manhattan),
            greedy(grid, start, target, Four, Manhattan),
            walk(grid, start, target, Four, Manhattan),
            theta_star(grid, start, target),
        ]
    };
    assert!(plans(&grid).iter().all(|plan| plan.as_ref().unwrap().length_m == 0.5));
    grid.block(Cell { column: 1, row: 0 });
    let unreachable = "no path leads from cell (0, 0) to cell (2, 0)";
    let dead_end = "dead end in cell (0, 0) after 0 moves: all its neighbours were visited";
    let errors = plans(&grid).map(|plan| plan.unwrap_err().to_string());
    assert_eq!(errors, [unreachable, unreachable, unreachable, dead_end, unreachable]);
}

#[test]
fn an_end_in_a_wall_or_outside_is_named() {
    let task = Task::new("S#T");
    let (wall, outside) = (Cell { column: 1, row: 0 }, Cell { column: 3, row: 0 });
    let text = |start, target| dijkstra(&task.grid, start, target, Four).unwrap_err().to_string();
    assert_eq!(text(wall, task.target), "the start is in the blocked cell (1, 0)");
    assert_eq!(text(task.start, wall), "the target is in the blocked cell (1, 0)");
    assert_eq!(text(task.start, outside), "the target (3, 0) is outside the grid of 3 columns by 1 rows");
    let walked = walk(&task.grid, wall, task.target, Four, Euclidean);
    assert_eq!(walked, Err(PlanError::Blocked { end: End::Start, cell: wall }));
    assert!(matches!(theta_star(&task.grid, outside, task.target), Err(PlanError::Outside { .. })));
}

#[test]
fn a_way_to_where_one_stands_has_no_length() {
    let task = Task::new("S.T");
    let plan = dijkstra(&task.grid, task.start, task.start, Four).unwrap();
    assert_eq!((plan.cells, plan.length_m), (vec![task.start], 0.0));
}

/// Grids of up to 14 by 14 cells, of which a good quarter is blocked, with free ends.
fn random_task() -> impl Strategy<Value = Task> {
    let size = (2..15_usize, 2..15_usize);
    size.prop_flat_map(|(columns, rows)| {
        let blocked = prop::collection::vec(prop::bool::weighted(0.27), columns * rows);
        let ends = (0..columns * rows, 0..columns * rows);
        (Just((columns, rows)), blocked, ends)
    })
    .prop_map(|((columns, rows), blocked, (start, target))| {
        let mut grid = Grid::new(columns, rows, 1.0, baudbot_geometry::Point::origin()).unwrap();
        let (start, target) = (grid.cell(start), grid.cell(target));
        for (number, blocked) in blocked.into_iter().enumerate() {
            let cell = grid.cell(number);
            if blocked && cell != start && cell != target {
                grid.block(cell);
            }
        }
        Task { grid, start, target }
    })
}

proptest! {
    /// Fig. 6.9 finds shortest ways.
    #[test]
    fn a_star_finds_ways_as_short_as_dijkstras_and_the_others_none_shorter(task in random_task()) {
        let eight = &[Euclidean, Octile][..];
        let admissible = [(Four, &[Manhattan, Euclidean, Octile][..]), (Eight, eight), (EightNoCut, eight)];
        for (moves, heuristics) in admissible {
            let Task { grid, start, target } = &task;
            let shortest = dijkstra(grid, *start, *target, moves);
            let Ok(shortest) = shortest else {
                for &heuristic in heuristics {
                    prop_assert_eq!(a_star(grid, *start, *target, moves, heuristic), shortest.clone());
                    prop_assert_eq!(greedy(grid, *start, *target, moves, heuristic), shortest.clone());
                    prop_assert!(walk(grid, *start, *target, moves, heuristic).is_err());
                }
                continue;
            };
            task.check(&shortest, moves);
            for &heuristic in heuristics {
                let plan = task.a_star(moves, heuristic);
                task.check(&plan, moves);
                prop_assert!((plan.length_m - shortest.length_m).abs() < 1e-9);
                let plan = greedy(grid, *start, *target, moves, heuristic).unwrap();
                task.check(&plan, moves);
                prop_assert!(plan.length_m >= shortest.length_m - 1e-9);
                if let Ok(plan) = walk(grid, *start, *target, moves, heuristic) {
                    task.check(&plan, moves);
                    prop_assert!(plan.length_m >= shortest.length_m - 1e-9);
                }
            }
        }
    }

    #[test]
    fn theta_star_finds_a_free_way_wherever_dijkstra_does(task in random_task()) {
        let Task { grid, start, target } = &task;
        let (any_angle, shortest) =
            (theta_star(grid, *start, *target), dijkstra(grid, *start, *target, EightNoCut));
        prop_assert_eq!(any_angle.is_ok(), shortest.is_ok());
        if let (Ok(any_angle), Ok(shortest)) = (any_angle, shortest) {
            prop_assert!(any_angle.cells.windows(2).all(|pair| line_of_sight(grid, pair[0], pair[1])));
            let straight = Euclidean.estimate(*start, *target);
            prop_assert!(any_angle.length_m >= straight - 1e-9);
            // A proof that the path is never longer is missing, though none of 20,000 such paths was.
            prop_assert!(any_angle.length_m <= shortest.length_m * 1.02);
        }
    }
}

/// The penalty of §6.2.1 on the three grids: A\* may expand fewer cells, and the path may be longer than the shortest one.
#[test]
fn a_penalty_for_obstacles_costs_optimality_and_may_save_cells() {
    let (mut expanded, mut lengths_m) = (vec![], vec![]);
    for text in [EMPTY, WALL, TRAP] {
        let task = Task::new(text);
        let shortest = task.dijkstra(EightNoCut);
        for penalty in [0.0, 1.0, 5.0, 20.0] {
            let heuristic = Penalised { heuristic: Euclidean, penalty };
            let plan = a_star(&task.grid, task.start, task.target, EightNoCut, heuristic).unwrap();
            task.check(&plan, EightNoCut);
            assert!(plan.length_m >= shortest.length_m - 1e-9);
            // An estimate is too large by no more than its penalties.
            assert!(plan.length_m <= shortest.length_m + penalty * 2.0, "{penalty}: {}", plan.length_m);
            lengths_m.push(plan.length_m);
            expanded.push(plan.expanded.len());
        }
    }
    // Behind a wall the search expands up to a quarter fewer cells; in a trap the penalty saves none.
    assert_eq!(expanded, [[57; 4], [135, 123, 104, 102], [127, 130, 127, 127]].concat());
    let figures = [[19.9706; 4], [21.3848, 21.3848, 22.2132, 22.2132], [20.8995, 22.5563, 23.3848, 23.3848]];
    for (length_m, figure) in lengths_m.into_iter().zip(figures.concat()) {
        assert!((length_m - figure).abs() < 5.1e-5, "{length_m} instead of {figure}");
    }
}

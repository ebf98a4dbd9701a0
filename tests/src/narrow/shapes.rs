//! The arenas' outlines.

use std::f64::consts::{PI, TAU};

use baudbot_brains::Chance;

use super::{Arena, Outline, Shape};

/// The arena of this layout, with passages of a width, in metres, for a body of another.
pub(super) fn arena(shape: Shape, passage_m: f64, body_m: f64, seed: u64) -> Arena {
    let w = passage_m;
    match shape {
        Shape::Straight => along(&[[0.0, 0.0], [12.0 * w, 0.0]], w),
        Shape::Serpentine => along(
            &[[0.0, 0.0], [5.0, 0.0], [5.0, 2.5], [0.0, 2.5], [0.0, 5.0], [5.0, 5.0]].map(|p| scaled(p, w)),
            w,
        ),
        Shape::Zigzag => {
            let bend = |i: i32| scaled([2.55 * f64::from(i), if i % 2 == 0 { 0.0 } else { 2.14 }], w);
            along(&(0..6).map(bend).collect::<Vec<_>>(), w)
        }
        Shape::Comb => comb(w),
        Shape::Star => star(w),
        Shape::Ring => {
            let side = |m: f64| vec![[-m, -m], [m, -m], [m, m], [-m, m]];
            let starts_m = vec![[2.0 * w, 0.0], [0.0, -2.0 * w], [-2.0 * w, 2.0 * w]];
            Arena { outlines: vec![wall(side(2.5 * w)), island(side(1.5 * w))], starts_m, people_m: vec![] }
        }
        Shape::RoundRing => {
            let starts_m = vec![[2.5 * w, 0.0], [0.0, -2.5 * w], [-2.5 * w, 0.0]];
            let outlines = vec![wall(round(3.0 * w / (PI / 40.0).cos(), 40)), island(round(2.0 * w, 40))];
            Arena { outlines, starts_m, people_m: vec![] }
        }
        Shape::Rooms => rooms(w, body_m, seed, false),
        Shape::CornerDoors => rooms(w, body_m, seed, true),
        Shape::Slanted => slanted(w, body_m),
        Shape::Islands => islands(w, body_m),
        Shape::People => people(),
    }
}

fn scaled([x, y]: [f64; 2], by: f64) -> [f64; 2] {
    [by * x, by * y]
}

fn wall(points_m: Vec<[f64; 2]>) -> Outline {
    Outline { points_m, is_closed: true, is_island: false }
}

fn island(points_m: Vec<[f64; 2]>) -> Outline {
    Outline { points_m, is_closed: true, is_island: true }
}

fn line(from: [f64; 2], to: [f64; 2]) -> Outline {
    Outline { points_m: vec![from, to], is_closed: false, is_island: false }
}

fn round(radius_m: f64, corners: u32) -> Vec<[f64; 2]> {
    let corner = |i: u32| TAU * f64::from(i) / f64::from(corners);
    (0..corners).map(|i| [radius_m * corner(i).cos(), radius_m * corner(i).sin()]).collect()
}

fn moved(points: &[[f64; 2]], [x, y]: [f64; 2]) -> Vec<[f64; 2]> {
    points.iter().map(|p| [p[0] + x, p[1] + y]).collect()
}

/// A corridor of a width along a line, which ends half a width before and behind it.
fn along(line_m: &[[f64; 2]], width_m: f64) -> Arena {
    let unit = |a: [f64; 2], b: [f64; 2]| {
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        [x / x.hypot(y), y / x.hypot(y)]
    };
    let half = 0.5 * width_m;
    let last = line_m.len() - 1;
    let side = |left: f64| -> Vec<[f64; 2]> {
        let place = |i: usize| {
            let before = unit(line_m[i.max(1) - 1], line_m[i.max(1)]);
            let behind = unit(line_m[i.min(last - 1)], line_m[i.min(last - 1) + 1]);
            // The point in which the two sides' lines meet.
            let (x, y) = (before[0] + behind[0], before[1] + behind[1]);
            let reach = half / (0.5 * x.hypot(y));
            let aside = [-y / x.hypot(y) * left * reach, x / x.hypot(y) * left * reach];
            let on = if i == 0 {
                -half
            } else if i == last {
                half
            } else {
                0.0
            };
            [line_m[i][0] + aside[0] + on * before[0], line_m[i][1] + aside[1] + on * before[1]]
        };
        (0..=last).map(place).collect()
    };
    let mut points_m = side(-1.0);
    points_m.extend(side(1.0).into_iter().rev());
    let middle = |pair: &[[f64; 2]]| [0.5 * (pair[0][0] + pair[1][0]), 0.5 * (pair[0][1] + pair[1][1])];
    let starts_m = line_m.windows(2).map(middle).chain([line_m[0]]).collect();
    Arena { outlines: vec![wall(points_m)], starts_m, people_m: vec![] }
}

fn comb(w: f64) -> Arena {
    let (teeth, gap, deep) = (4, 0.8 * w, 4.0 * w);
    let mut points = vec![];
    for tooth in 0..teeth {
        let x = f64::from(tooth) * (w + gap);
        points.extend([[x, w], [x, w + deep], [x + w, w + deep], [x + w, w]]);
    }
    let right = points[points.len() - 1][0];
    points.extend([[right, 0.0], [0.0, 0.0]]);
    points.reverse();
    Arena {
        outlines: vec![wall(points)],
        starts_m: vec![[0.5 * w, 0.5 * w], [0.5 * w, w + 0.5 * deep], [right - 0.5 * w, w + 0.5 * deep]],
        people_m: vec![],
    }
}

fn star(w: f64) -> Arena {
    let arms = 5;
    let (inner, deep) = (0.5 * w / (PI / f64::from(arms)).sin(), 5.0 * w);
    let mut points = vec![];
    let mut starts_m = vec![[0.0, 0.0]];
    for arm in 0..arms {
        let angle = 0.3 + TAU * f64::from(arm) / f64::from(arms);
        let (sin, cos) = angle.sin_cos();
        let end = |aside: f64| [deep * cos - aside * sin, deep * sin + aside * cos];
        points.extend([end(-0.5 * w), end(0.5 * w)]);
        let between = angle + PI / f64::from(arms);
        points.push([inner * between.cos(), inner * between.sin()]);
        starts_m.push([0.6 * deep * cos, 0.6 * deep * sin]);
    }
    Arena { outlines: vec![wall(points)], starts_m, people_m: vec![] }
}

/// Three by two rooms; between neighbours there is a door.
fn rooms(door_m: f64, body_m: f64, seed: u64, in_corners: bool) -> Arena {
    let side = (6.0 * body_m).max(door_m + 2.0 * body_m);
    let mut chance = Chance::new(seed, "doors");
    let mut begin = |from: f64| {
        let spare = side - door_m;
        let part = chance.uniform();
        from + if in_corners { if part < 0.5 { 0.0 } else { spare } } else { (0.05 + 0.9 * part) * spare }
    };
    let mut outlines =
        vec![wall(vec![[0.0, 0.0], [3.0 * side, 0.0], [3.0 * side, 2.0 * side], [0.0, 2.0 * side]])];
    let mut add = |from: [f64; 2], to: [f64; 2]| {
        if (from[0] - to[0]).hypot(from[1] - to[1]) > 1e-6 {
            outlines.push(line(from, to));
        }
    };
    for column in 0..3 {
        let x = f64::from(column) * side;
        for row in 0..2 {
            let y = f64::from(row) * side;
            if column > 0 {
                let at = begin(y);
                add([x, y], [x, at]);
                add([x, at + door_m], [x, y + side]);
            }
            if row > 0 {
                let at = begin(x);
                add([x, y], [at, y]);
                add([at + door_m, y], [x + side, y]);
            }
        }
    }
    let starts_m = vec![[0.5 * side, 0.5 * side], [1.5 * side, 1.4 * side], [2.6 * side, 0.4 * side]];
    Arena { outlines, starts_m, people_m: vec![] }
}

fn slanted(door_m: f64, body_m: f64) -> Arena {
    let side = (8.0 * body_m).max(2.5 * door_m);
    let ends = [[0.8 * side, 0.0], [1.6 * side, side]];
    let (x, y) = (ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
    let length = x.hypot(y);
    let at = |m: f64| [ends[0][0] + x * m / length, ends[0][1] + y * m / length];
    let begin = 0.6 * (length - door_m);
    let outlines = vec![
        wall(vec![[0.0, 0.0], [2.4 * side, 0.3 * side], [2.2 * side, side], [0.2 * side, 1.2 * side]]),
        // A little farther than the border, so that nothing is left open.
        line([ends[0][0], 0.0], at(begin)),
        line(at(begin + door_m), [ends[1][0] + 0.2 * x, ends[1][1] + 0.2 * y]),
    ];
    let starts_m = vec![[0.5 * side, 0.6 * side], [1.9 * side, 0.6 * side]];
    Arena { outlines, starts_m, people_m: vec![] }
}

/// Three by three islands, by turns round and square, with gaps between them and beside them.
fn islands(gap_m: f64, body_m: f64) -> Arena {
    let size = 1.6 * body_m;
    let pitch = size + gap_m;
    let whole = 3.0 * pitch + gap_m;
    let mut outlines = vec![wall(vec![[0.0, 0.0], [whole, 0.0], [whole, whole], [0.0, whole]])];
    for i in 0..9 {
        let center = [i % 3, i / 3].map(|i| gap_m + 0.5 * size + f64::from(i) * pitch);
        let half = 0.5 * size;
        let square = vec![[-half, -half], [half, -half], [half, half], [-half, half]];
        outlines.push(island(moved(&if i % 2 == 0 { square } else { round(half, 24) }, center)));
    }
    let starts_m = vec![[0.5 * gap_m; 2], [whole - 0.5 * gap_m, 0.5 * whole], [0.5 * gap_m + pitch; 2]];
    Arena { outlines, starts_m, people_m: vec![] }
}

/// An arena as large as people need, whatever the body.
fn people() -> Arena {
    let outlines = vec![
        wall(vec![[0.0, 0.0], [8.0, 0.0], [8.0, 6.0], [0.0, 6.0]]),
        line([4.0, 0.0], [4.0, 2.0]),
        line([4.0, 3.6], [4.0, 6.0]),
    ];
    Arena {
        outlines,
        starts_m: vec![[1.0, 1.0], [1.0, 5.0], [7.0, 1.0]],
        people_m: vec![[2.5, 4.0], [5.5, 3.0], [6.5, 4.5]],
    }
}

//! The floor plans of the workloads: `crates/bench/geometry/README.md` has their format.

use std::str::FromStr;

/// The things on a floor, and the starts of robots. Metres and radians.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// Width and height of the floor.
    pub size: [f64; 2],
    /// Outer and inner walls: segments from a point to another.
    pub walls: Vec<[f64; 4]>,
    /// Boxes: centre, width, height.
    pub boxes: Vec<[f64; 4]>,
    /// Centres of cylinders of radius [`CYLINDER_RADIUS_M`].
    pub cylinders: Vec<[f64; 2]>,
    /// The starts of robots: a point and a heading.
    pub robots: Vec<[f64; 3]>,
}

/// Radius of a cylinder.
pub const CYLINDER_RADIUS_M: f64 = 0.05;

/// An invalid line of a plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: `{text}`: {remedy}")]
pub struct PlanError {
    /// The number of the line, from 1.
    pub line: usize,
    /// The line.
    pub text: String,
    /// The remedy.
    pub remedy: Remedy,
}

/// The correct form of a line of a plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Remedy {
    /// A word that a plan knows comes first.
    #[error("begin with size, outer, wall, desk, box, cyl or robot")]
    Word,
    /// As many finite numbers as the word takes follow it.
    #[error("`{text}` must be {count} numbers")]
    Numbers {
        /// The text in their place.
        text: String,
        /// The count of the numbers.
        count: usize,
    },
}

impl FromStr for Plan {
    type Err = PlanError;

    fn from_str(text: &str) -> Result<Self, PlanError> {
        let mut plan = Self::default();
        let mut has_outer_walls = false;
        for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            has_outer_walls |= line.starts_with("outer ");
            let wrong = |remedy| PlanError { line: i + 1, text: line.to_owned(), remedy };
            plan.read(line).map_err(wrong)?;
        }
        if !has_outer_walls {
            let [w, h] = plan.size;
            plan.walls.extend([[0.0, 0.0, w, 0.0], [w, 0.0, w, h], [w, h, 0.0, h], [0.0, h, 0.0, 0.0]]);
        }
        Ok(plan)
    }
}

impl Plan {
    fn read(&mut self, line: &str) -> Result<(), Remedy> {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "size" => self.size = numbers(rest)?,
            "outer" | "wall" => self.walls.push(numbers(rest)?),
            "desk" => self.boxes.push(numbers(rest)?),
            "box" => {
                let [x, y] = numbers(rest)?;
                self.boxes.push([x, y, BOX_SIDE_M, BOX_SIDE_M]);
            }
            "cyl" => self.cylinders.push(numbers(rest)?),
            "robot" => self.robots.push(numbers(rest)?),
            _ => return Err(Remedy::Word),
        }
        Ok(())
    }

    /// Floors like this side by side, so many in each direction. What two of them have between them stands there once.
    pub fn tiled(&self, side: usize) -> Self {
        let mut all = Self { size: self.size.map(|length| length * side as f64), ..Self::default() };
        for (column, row) in (0..side * side).map(|i| (i % side, i / side)) {
            let (dx, dy) = (column as f64 * self.size[0], row as f64 * self.size[1]);
            let is_first = |&[x0, y0, x1, y1]: &[f64; 4]| {
                (column == 0 || x0 > 0.0 || x1 > 0.0) && (row == 0 || y0 > 0.0 || y1 > 0.0)
            };
            let walls = self.walls.iter().filter(|wall| is_first(wall));
            all.walls.extend(walls.map(|[x0, y0, x1, y1]| [x0 + dx, y0 + dy, x1 + dx, y1 + dy]));
            all.boxes
                .extend(self.boxes.iter().map(|[x, y, width, height]| [x + dx, y + dy, *width, *height]));
            all.cylinders.extend(self.cylinders.iter().map(|[x, y]| [x + dx, y + dy]));
            all.robots.extend(self.robots.iter().map(|[x, y, heading]| [x + dx, y + dy, *heading]));
        }
        all
    }

    /// The number of segments of the walls and boxes.
    pub fn segments(&self) -> usize {
        self.walls.len() + 4 * self.boxes.len()
    }
}

fn numbers<const N: usize>(text: &str) -> Result<[f64; N], Remedy> {
    let found: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    let found = found.filter(|numbers| numbers.iter().all(|number: &f64| number.is_finite()));
    let found = found.and_then(|numbers| numbers.try_into().ok());
    found.ok_or_else(|| Remedy::Numbers { text: text.to_owned(), count: N })
}

/// Side of a `box`.
const BOX_SIDE_M: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_alone_is_a_closed_rectangle() {
        let plan: Plan = "size 2 1\nbox 0.5 0.5\n\ncyl 1 0.5\nrobot 1.5 0.5 3.0\n".parse().unwrap();
        assert_eq!(plan.segments(), 8);
        assert_eq!(plan.walls[1], [2.0, 0.0, 2.0, 1.0]);
        assert_eq!(plan.boxes, [[0.5, 0.5, 0.1, 0.1]]);
        assert_eq!((plan.cylinders.len(), plan.robots.len()), (1, 1));
    }

    #[test]
    fn outer_walls_stand_for_the_rectangle() {
        let plan: Plan = "size 2 1\nouter 0 0 2 0\nwall 1 0 1 0.5\ndesk 1 1 0.5 0.25".parse().unwrap();
        assert_eq!((plan.walls.len(), plan.segments()), (2, 6));
    }

    #[test]
    fn floors_side_by_side_share_the_walls_between_them() {
        let plan: Plan =
            "size 2 1\nwall 1 0 1 0.5\nbox 0.5 0.5\ncyl 1 0.75\nrobot 1.5 0.5 3.0\n".parse().unwrap();
        let four = plan.tiled(2);
        assert_eq!(four.size, [4.0, 2.0]);
        assert_eq!((four.walls.len(), four.segments()), (12 + 4, 12 + 4 + 16));
        assert!(four.walls.contains(&[3.0, 1.0, 3.0, 1.5]), "{:?}", four.walls);
        assert_eq!(four.robots[3], [3.5, 1.5, 3.0]);
        assert_eq!((four.boxes[1][0], four.cylinders[2]), (2.5, [1.0, 1.75]));
        assert_eq!(plan.tiled(1), plan);
    }

    #[test]
    fn a_line_that_says_nothing_is_named() {
        let error = |text: &str| text.parse::<Plan>().unwrap_err().to_string();
        assert_eq!(error("size 1 1\nrobot 1 2"), "line 2: `robot 1 2`: `1 2` must be 3 numbers");
        assert_eq!(error("cyl 1 nan"), "line 1: `cyl 1 nan`: `1 nan` must be 2 numbers");
        assert_eq!(
            error("door 1 2"),
            "line 1: `door 1 2`: begin with size, outer, wall, desk, box, cyl or robot"
        );
    }
}

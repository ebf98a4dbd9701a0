//! Shapes of a drawing that are no walls but places: where a robot starts, and the goal.

use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value};
use usvg::Tree;

use super::entry::{Purpose, Wanted};
use super::outlines::Placement;
use super::problem::DrawingError;
use super::shape::tidy;
use crate::error::ImportError;
use crate::tables;

/// A place that was found.
#[derive(Debug)]
pub(crate) struct Mark {
    purpose: Purpose,
    center_m: [f64; 2],
    /// Half the smaller of its sides.
    radius_m: f64,
}

impl Wanted {
    /// The place of its shape in the drawing.
    pub(crate) fn find(&self, tree: &Tree, placement: &Placement) -> Result<Mark, DrawingError> {
        let id = &self.id;
        let node = tree.node_by_id(id);
        let no_place = || DrawingError::NoPlace { id: id.clone(), purpose: self.purpose.clone() };
        let node = node.ok_or_else(no_place)?;
        let around = node.abs_bounding_box();
        let middle =
            [0.5 * (around.left() + around.right()), 0.5 * (around.top() + around.bottom())].map(f64::from);
        let sides = [around.width(), around.height()].map(f64::from);
        let center_m = placement
            .of_drawing(middle)
            .map_err(|problem| DrawingError::Shape { shape: format!("the shape `{id}`"), problem })?;
        let radius_m = tidy(0.5 * sides[0].min(sides[1]) * placement.scale.m_per_unit);
        if matches!(self.purpose, Purpose::Goal) && radius_m <= 0.0 {
            return Err(DrawingError::NoArea(id.clone()));
        }
        Ok(Mark { purpose: self.purpose.clone(), center_m, radius_m })
    }
}

impl Mark {
    /// Puts the place into the scenario; `path` is the map's.
    pub(crate) fn put(&self, document: &mut DocumentMut, path: &str) -> Result<(), ImportError> {
        match &self.purpose {
            Purpose::Start(robot) => self.put_start(document, robot, path),
            Purpose::Goal => self.put_goal(document, path),
        }
    }

    fn put_start(&self, document: &mut DocumentMut, name: &str, path: &str) -> Result<(), ImportError> {
        let wrong = |problem: String| ImportError::field(format!("{path}.starts.{name}"), problem);
        let mut robots = document.get_mut("robots").map(tables::of).unwrap_or_default();
        let robot =
            robots.iter_mut().find(|(_, robot)| robot.get("name").and_then(Item::as_str) == Some(name));
        let Some((_, robot)) = robot else { return Err(wrong(format!("there is no robot `{name}`"))) };
        if robot.contains_key("starts") {
            return Err(wrong("the robot has `starts` of its own: take one of them out".to_owned()));
        }
        let start = robot.entry("start").or_insert_with(|| Item::Value(InlineTable::new().into()));
        let Some(start) = start.as_table_like_mut() else {
            return Err(wrong("the robot's `start` is no table".to_owned()));
        };
        if start.contains_key("x_m") || start.contains_key("y_m") {
            return Err(wrong("the robot has a `start` of its own: take x_m and y_m out of it".to_owned()));
        }
        self.insert_center(start);
        Ok(())
    }

    fn put_goal(&self, document: &mut DocumentMut, path: &str) -> Result<(), ImportError> {
        let wrong = |problem: &str| ImportError::field(format!("{path}.goal"), problem);
        let end = document.entry("end").or_insert_with(|| Item::Table(Table::new()));
        let Some(end) = end.as_table_like_mut() else { return Err(wrong("`end` is no table")) };
        if end.contains_key("goal") {
            return Err(wrong("the scenario has an `end.goal`: take one of them out"));
        }
        let mut goal = InlineTable::new();
        self.insert_center(&mut goal);
        goal.insert("radius_m", self.radius_m.into());
        end.insert("goal", Item::Value(Value::InlineTable(goal)));
        Ok(())
    }

    fn insert_center(&self, table: &mut dyn TableLike) {
        let [x_m, y_m] = self.center_m;
        table.insert("x_m", Item::Value(x_m.into()));
        table.insert("y_m", Item::Value(y_m.into()));
    }
}

//! The charts that an experiment asks for.

use crate::error::Error;
use crate::factor::{Field, place};
use crate::figures::Figure;
use crate::raw::{self, ChartKind};

/// A drawing of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// The figure that it shows; `None` is the share of runs that succeed.
    pub figure: Option<Figure>,
    /// The kind of the chart.
    pub kind: ChartKind,
    /// The field along the horizontal axis, by its place.
    pub x: usize,
    /// The field with a line each, or along the vertical axis of colours, by its place.
    pub by: Option<usize>,
    /// The title above it, if the file has one.
    pub title: Option<String>,
    /// Whether it shows differences from the first combination, seed by seed.
    pub is_difference: bool,
}

/// The charts of an experiment that asks for none: how its one or two fields decide over success and distance.
pub(crate) fn usual_charts(fields: usize, has_success: bool) -> Vec<raw::Chart> {
    let kinds: &[ChartKind] = match fields {
        1 => &[ChartKind::Lines],
        2 => &[ChartKind::Lines, ChartKind::Heat],
        _ => &[],
    };
    let figures = [if has_success { "success" } else { "collisions" }, "distance_m"];
    let chart = |figure: &str, kind| raw::Chart {
        figure: figure.to_owned(),
        kind,
        x: None,
        by: None,
        title: None,
        difference: false,
    };
    figures.into_iter().flat_map(|figure| kinds.iter().map(move |&kind| chart(figure, kind))).collect()
}

pub(crate) fn chart_of(i: usize, raw: raw::Chart, fields: &[Field], success: bool) -> Result<Chart, Error> {
    let at = |name: &str| format!("charts[{i}].{name}");
    let figure = match raw.figure.as_str() {
        "success" if success => None,
        "success" => {
            return Err(Error::field(at("figure"), "there is no [success] section, which defines success"));
        }
        name => Some(Figure::named(name).map_err(|problem| Error::field(at("figure"), problem))?),
    };
    let find =
        |field: &str, name: &str| place(fields, name).map_err(|problem| Error::field(at(field), problem));
    let x = match &raw.x {
        Some(name) => find("x", name)?,
        None => fields.iter().position(Field::is_numeric).unwrap_or(0),
    };
    let by = match &raw.by {
        Some(name) => Some(find("by", name)?),
        // Lines for the parts of a range would be a tangle.
        None => (0..fields.len())
            .find(|&i| i != x && (raw.kind == ChartKind::Heat || fields[i].levels().is_some())),
    };
    if by == Some(x) {
        return Err(Error::field(at("by"), "is the same field as `x`"));
    }
    if raw.kind == ChartKind::Heat && by.is_none() {
        return Err(Error::field(at("kind"), "a heat map needs two [[fields]], there is one"));
    }
    Ok(Chart { figure, kind: raw.kind, x, by, title: raw.title, is_difference: raw.difference })
}

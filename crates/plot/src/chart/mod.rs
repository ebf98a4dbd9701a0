//! Charts: values over one or two fields as lines or as a heat map, the [`progress`] of a tuning, values [`over_time`],
//! measured values beside simulated ones ([`compared`]), a [`scatter`] of places, paths in the [`space`] of a
//! motivational state, and the [`residuals`] of a fit.
//!
//! `lines` and `heat` draw a [`Chart`]; `page` has what several charts share: title, frame and the names of axes.

pub mod compared;
mod heat;
mod lines;
pub mod over_time;
mod page;
pub mod progress;
pub mod residuals;
pub mod scatter;
pub mod space;

use std::collections::BTreeMap;

use crate::scale::{Scale, number, percent};

/// Measured values over one field or two.
#[derive(Clone, Debug)]
pub struct Chart {
    /// The first line.
    pub title: String,
    /// The line below it.
    pub subtitle: String,
    /// The horizontal axis.
    pub x: Field,
    /// A line for each of its values, or the vertical axis of a heat map.
    pub by: Option<Field>,
    /// The quantity that was measured.
    pub figure: Figure,
    /// The point of each pair of values, by their places in [`x`](Self::x) and [`by`](Self::by), which is 0 without
    /// the latter.
    pub points: BTreeMap<(usize, usize), Point>,
}

/// A field that was varied.
#[derive(Clone, Debug)]
pub struct Field {
    /// The name of the field in sentences.
    pub label: String,
    /// The name of the field with its unit.
    pub title: String,
    /// The field's values: their names, and their numbers if they are numbers.
    pub values: Vec<(String, Option<f64>)>,
}

/// The quantity that a chart shows.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The name of the figure.
    pub title: String,
    /// The values that it can have.
    pub range: Range,
}

/// The values that a figure can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Shares. The scale goes from 0 to 1, whatever the values are.
    WholeShares,
    /// Shares. The scale fits the values.
    Shares,
    /// Numbers. The scale fits the values.
    Numbers,
}

/// A measured value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The value.
    pub value: f64,
    /// The point's confidence interval.
    pub interval: Option<(f64, f64)>,
}

impl Chart {
    /// Lines with bands, as SVG.
    pub fn lines(&self) -> String {
        lines::draw(self)
    }

    /// A heat map, as SVG; empty without a second field.
    pub fn heat_map(&self) -> String {
        self.by.as_ref().map(|by| heat::draw(self, by)).unwrap_or_default()
    }
}

impl Field {
    fn is_numeric(&self) -> bool {
        self.values.iter().all(|(_, number)| number.is_some())
    }
}

impl Figure {
    /// The scale of these values.
    fn scale(&self, values: &[f64], pixels: (f64, f64)) -> Scale {
        match self.range {
            Range::WholeShares => Scale::share(pixels),
            Range::Shares => {
                Scale::round(&values.iter().map(|value| value.min(1.0)).collect::<Vec<_>>(), pixels)
            }
            Range::Numbers => Scale::round(values, pixels),
        }
    }

    /// A value in words.
    fn words(&self, value: f64) -> String {
        match self.range {
            Range::WholeShares | Range::Shares => percent(value),
            Range::Numbers => number(value),
        }
    }
}

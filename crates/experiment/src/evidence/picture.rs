//! The picture of a comparison.

use baudbot_plot::chart::compared::{Chart, Point, Value};

use crate::evidence::at::At;
use crate::evidence::comparison::{Compared, Comparison};

/// Measured and simulated values as SVG.
pub(crate) fn picture(comparison: &Comparison, points: &[Compared<'_>]) -> String {
    let chart = Chart {
        title: comparison.title.clone(),
        subtitle: "means; bars: one standard deviation".into(),
        x: comparison.x.clone(),
        y: comparison.y.clone(),
        points: points.iter().map(point).collect(),
    };
    chart.draw()
}

fn point(point: &Compared<'_>) -> Point {
    let (measured, simulated) = (point.measured, point.simulated);
    let number = match measured.at {
        At::Number(number) => Some(number),
        At::Name(_) => None,
    };
    Point {
        name: measured.at.to_string(),
        x: number,
        measured: Value { mean: measured.mean, sd: measured.sd },
        simulated: Value { mean: simulated.mean, sd: Some(simulated.sd) },
        agrees: point.agrees,
    }
}

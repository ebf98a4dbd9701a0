//! Checks of what a brain publishes: whether a page can show it. An error names the field that is wrong.

use baudbot_fields::printable::{Printable, is_printable};
use baudbot_proto::v1;
use prost::Message as _;
use tonic::Status;

use crate::beliefs;

/// Checks a belief. Gives it with its robot; `robots` are those of the brain's stream.
///
/// # Errors
/// `INVALID_ARGUMENT` with the field that is wrong.
pub(crate) fn checked(annotate: v1::Annotate, robots: &[usize]) -> Result<(usize, v1::Belief), Status> {
    let slot = annotate.robot as usize;
    let Some(&robot) = robots.get(slot) else {
        let text = format!("annotate.robot: must be 0 to {}, is {slot}", robots.len() - 1);
        return Err(Status::invalid_argument(text));
    };
    let belief = annotate.belief.unwrap_or_default();
    let bytes = belief.encoded_len();
    if bytes > beliefs::MAX_BYTES {
        let text = format!("annotate.belief: has {bytes} bytes, the limit is {}", beliefs::MAX_BYTES);
        return Err(Status::invalid_argument(text));
    }
    check_words(&belief)?;
    check_lists(&belief)?;
    check_numbers(&belief)?;
    Ok((robot, belief))
}

/// Checks the texts, since they go to terminals, too.
fn check_words(belief: &v1::Belief) -> Result<(), Status> {
    let names = belief.utilities.iter().enumerate();
    let names = names.map(|(i, utility)| (format!("utilities[{i}].name"), &utility.name));
    let motivation = belief.motivation.iter();
    let variables = motivation.clone().flat_map(|motivation| motivation.variables.iter().enumerate());
    let variables =
        variables.map(|(i, variable)| (format!("motivation.variables[{i}].name"), &variable.name));
    let tendencies = motivation.flat_map(|motivation| motivation.tendencies.iter().enumerate());
    let tendencies =
        tendencies.map(|(i, tendency)| (format!("motivation.tendencies[{i}].name"), &tendency.name));
    let state = std::iter::once(("state".to_owned(), &belief.state));
    let mut words = state.chain(names).chain(variables).chain(tendencies);
    let Some((field, text)) = words.find(|(_, text)| !text.chars().all(is_printable)) else { return Ok(()) };
    let text = Printable(text);
    Err(invalid(&field, format!("must be on one line and without control characters, is `{text}`")))
}

/// Checks the lengths of lists, since what is short on the wire may be long in memory.
fn check_lists(belief: &v1::Belief) -> Result<(), Status> {
    let too_many =
        |field: &str, n: usize, most: usize| invalid(field, format!("there are {n}, the limit is {most}"));
    let (variables, tendencies) =
        belief.motivation.as_ref().map_or((0, 0), |state| (state.variables.len(), state.tendencies.len()));
    let lists = [
        ("utilities", belief.utilities.len(), 256),
        ("path", belief.path.len(), 10_000),
        ("motivation.variables", variables, 256),
        ("motivation.tendencies", tendencies, 256),
    ];
    if let Some((field, n, most)) = lists.into_iter().find(|(_, n, most)| n > most) {
        return Err(too_many(field, n, most));
    }
    check_weights(belief.motivation.as_ref())?;
    let entries = belief.pose.as_ref().map_or(0, |pose| pose.covariance_m2.len());
    if entries != 0 && entries != 3 {
        return Err(invalid(
            "pose.covariance_m2",
            format!("must have 3 entries (xx, xy, yy) or none, has {entries}"),
        ));
    }
    let Some(map) = &belief.map else { return Ok(()) };
    let columns = map.columns as usize;
    let rows = map.cells.len().checked_div(columns).unwrap_or(0);
    if columns > MAX_MAP_SIDE || rows > MAX_MAP_SIDE || rows * columns != map.cells.len() {
        let cells = map.cells.len();
        let problem =
            format!("{cells} cells in {columns} columns are not a grid of at most {MAX_MAP_SIDE} a side");
        return Err(invalid("map", problem));
    }
    Ok(())
}

/// Checks that tendencies have a weight for each variable, or none.
fn check_weights(motivation: Option<&v1::Motivation>) -> Result<(), Status> {
    let Some(v1::Motivation { variables, tendencies }) = motivation else { return Ok(()) };
    let wrong = |tendency: &v1::Tendency| ![0, variables.len()].contains(&tendency.weights.len());
    let Some(i) = tendencies.iter().position(wrong) else { return Ok(()) };
    let (n, weights) = (variables.len(), tendencies[i].weights.len());
    let field = format!("motivation.tendencies[{i}].weights");
    Err(invalid(&field, format!("must have one for each of the {n} variables or none, has {weights}")))
}

fn check_motivation(v1::Motivation { variables, tendencies }: &v1::Motivation) -> Result<(), Status> {
    for (i, variable) in variables.iter().enumerate() {
        let numbers = [
            ("value", Some(variable.value)),
            ("lethal_below", variable.lethal_below),
            ("lethal_above", variable.lethal_above),
        ];
        for (field, number) in numbers {
            finite(|| format!("motivation.variables[{i}].{field}"), number.unwrap_or_default())?;
        }
    }
    for (i, tendency) in tendencies.iter().enumerate() {
        finite(|| format!("motivation.tendencies[{i}].bias"), tendency.bias)?;
        for (j, weight) in tendency.weights.iter().enumerate() {
            finite(|| format!("motivation.tendencies[{i}].weights[{j}]"), *weight)?;
        }
    }
    Ok(())
}

/// Checks the numbers, since what is not finite cannot be drawn.
fn check_numbers(belief: &v1::Belief) -> Result<(), Status> {
    for (i, utility) in belief.utilities.iter().enumerate() {
        finite(|| format!("utilities[{i}].value"), utility.value)?;
    }
    belief.motivation.as_ref().map_or(Ok(()), check_motivation)?;
    if let Some(pose) = &belief.pose {
        for (field, number) in [("x_m", pose.x_m), ("y_m", pose.y_m), ("heading_rad", pose.heading_rad)] {
            finite(|| format!("pose.{field}"), number)?;
        }
        for (i, &number) in pose.covariance_m2.iter().enumerate() {
            finite(|| format!("pose.covariance_m2[{i}]"), number)?;
        }
    }
    for (i, particle) in belief.particles.iter().enumerate() {
        let v1::Particle { x_m, y_m, heading_rad, weight } = *particle;
        for (field, number) in [("x_m", x_m), ("y_m", y_m), ("heading_rad", heading_rad), ("weight", weight)]
        {
            finite(|| format!("particles[{i}].{field}"), number.into())?;
        }
    }
    for (i, point) in belief.path.iter().enumerate() {
        for (field, number) in [("x_m", point.x_m), ("y_m", point.y_m)] {
            finite(|| format!("path[{i}].{field}"), number)?;
        }
    }
    let Some(map) = &belief.map else { return Ok(()) };
    for (field, number) in [("x_m", map.x_m), ("y_m", map.y_m), ("cell_m", map.cell_m)] {
        finite(|| format!("map.{field}"), number)?;
    }
    if map.cell_m > 0.0 || map.cells.is_empty() {
        return Ok(());
    }
    Err(invalid("map.cell_m", format!("must be positive, is {}", map.cell_m)))
}

fn finite(field: impl FnOnce() -> String, number: f64) -> Result<(), Status> {
    if number.is_finite() {
        return Ok(());
    }
    Err(invalid(&field(), format!("must be a finite number, is {number}")))
}

fn invalid(field: &str, problem: impl std::fmt::Display) -> Status {
    Status::invalid_argument(format!("annotate.belief.{field}: {problem}"))
}

/// Most columns and rows of a map.
const MAX_MAP_SIDE: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;

    /// The error for an invalid belief.
    fn refused(change: impl FnOnce(&mut v1::Belief)) -> String {
        let mut belief = v1::Belief {
            utilities: vec![v1::Utility { name: "go".into(), value: 0.5, active: true }],
            pose: Some(v1::BelievedPose { covariance_m2: vec![1.0, 0.0, 1.0], ..Default::default() }),
            particles: vec![v1::Particle::default()],
            path: vec![v1::Point::default()],
            motivation: Some(v1::Motivation {
                variables: vec![v1::StateVariable { lethal_above: Some(1.0), ..Default::default() }],
                tendencies: vec![v1::Tendency { weights: vec![1.0], ..Default::default() }],
            }),
            map: Some(v1::GridMap { cell_m: 0.1, columns: 1, cells: vec![0], ..Default::default() }),
            ..Default::default()
        };
        let sound = v1::Annotate { robot: 0, belief: Some(belief.clone()) };
        assert_eq!(checked(sound, &[7]).unwrap(), (7, belief.clone()));
        change(&mut belief);
        let status = checked(v1::Annotate { robot: 0, belief: Some(belief) }, &[7]).unwrap_err();
        assert_eq!(status.code(), tonic::Code::InvalidArgument);
        status.message().strip_prefix("annotate.belief.").unwrap().to_owned()
    }

    fn pose(belief: &mut v1::Belief) -> &mut v1::BelievedPose {
        belief.pose.as_mut().unwrap()
    }

    fn map(belief: &mut v1::Belief) -> &mut v1::GridMap {
        belief.map.as_mut().unwrap()
    }

    fn motivation(belief: &mut v1::Belief) -> &mut v1::Motivation {
        belief.motivation.as_mut().unwrap()
    }

    #[test]
    fn a_belief_that_cannot_be_drawn_is_refused_with_the_field() {
        const ODD: [f64; 2] = [f64::NAN, f64::INFINITY];
        for odd in ODD {
            let found = [
                refused(|b| b.utilities[0].value = odd),
                refused(|b| pose(b).x_m = odd),
                refused(|b| pose(b).y_m = odd),
                refused(|b| pose(b).heading_rad = odd),
                refused(|b| pose(b).covariance_m2[2] = odd),
                refused(|b| b.particles[0].x_m = odd as f32),
                refused(|b| b.particles[0].weight = odd as f32),
                refused(|b| b.path[0].y_m = odd),
                refused(|b| motivation(b).variables[0].lethal_above = Some(odd)),
                refused(|b| motivation(b).variables[0].value = odd),
                refused(|b| motivation(b).tendencies[0].bias = odd),
                refused(|b| motivation(b).tendencies[0].weights[0] = odd),
                refused(|b| map(b).x_m = odd),
                refused(|b| map(b).cell_m = odd),
            ];
            let fields = [
                "utilities[0].value",
                "pose.x_m",
                "pose.y_m",
                "pose.heading_rad",
                "pose.covariance_m2[2]",
                "particles[0].x_m",
                "particles[0].weight",
                "path[0].y_m",
                "motivation.variables[0].lethal_above",
                "motivation.variables[0].value",
                "motivation.tendencies[0].bias",
                "motivation.tendencies[0].weights[0]",
                "map.x_m",
                "map.cell_m",
            ];
            assert_eq!(found, fields.map(|field| format!("{field}: must be a finite number, is {odd}")));
        }
        for entries in [1, 2, 4] {
            let problem = refused(|b| pose(b).covariance_m2 = vec![1.0; entries]);
            let words =
                format!("pose.covariance_m2: must have 3 entries (xx, xy, yy) or none, has {entries}");
            assert_eq!(problem, words);
        }
        let problem = "must be on one line and without control characters, is";
        assert_eq!(refused(|b| b.state = "a\nb".into()), format!("state: {problem} `a\\nb`"));
        let hostile = refused(|b| b.utilities[0].name = "\u{1b}[2J".into());
        assert_eq!(hostile, format!("utilities[0].name: {problem} `\\u{{1b}}[2J`"));
        let hostile = refused(|b| motivation(b).variables[0].name = "\n".into());
        assert_eq!(hostile, format!("motivation.variables[0].name: {problem} `\\n`"));
        assert_eq!(
            refused(|b| motivation(b).tendencies[0].weights = vec![1.0, 2.0]),
            "motivation.tendencies[0].weights: must have one for each of the 1 variables or none, has 2"
        );
        let many = |b: &mut v1::Belief| motivation(b).tendencies = vec![v1::Tendency::default(); 257];
        assert_eq!(refused(many), "motivation.tendencies: there are 257, the limit is 256");
        assert_eq!(refused(|b| map(b).cell_m = 0.0), "map.cell_m: must be positive, is 0");
        assert_eq!(
            refused(|b| map(b).columns = 2),
            "map: 1 cells in 2 columns are not a grid of at most 4096 a side"
        );
    }
}

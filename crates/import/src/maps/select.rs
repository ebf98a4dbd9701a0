//! The choice of the shapes of a drawing that are walls: by layer, id, class, and the colours of stroke and fill.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use svgtypes::Color;

use super::problem::SelectorError;

/// One of the things that a shape may be chosen by, such as `layer=Walls` or `stroke=#000000`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Selector {
    /// The text in the scenario.
    text: String,
    by: By,
}

#[derive(Clone, Debug, PartialEq)]
enum By {
    Layer(String),
    Id(String),
    Class(String),
    Fill(Paint),
    Stroke(Paint),
}

/// The paint of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Paint {
    Nothing,
    Rgb(u8, u8, u8),
    /// A gradient or a pattern, which no selector names.
    Other,
}

/// The traits by which a shape is chosen.
#[derive(Debug, Default)]
pub(crate) struct Traits {
    /// The layers of the element, and of all groups that it is in.
    pub(crate) layers: BTreeSet<String>,
    pub(crate) ids: BTreeSet<String>,
    pub(crate) classes: BTreeSet<String>,
    pub(crate) fill: Option<Paint>,
    pub(crate) stroke: Option<Paint>,
}

impl FromStr for Selector {
    type Err = SelectorError;

    fn from_str(text: &str) -> Result<Self, SelectorError> {
        let wrong = || SelectorError::Form(text.to_owned());
        let (kind, value) = text.split_once('=').ok_or_else(wrong)?;
        let value = value.trim();
        if value.is_empty() {
            return Err(wrong());
        }
        let by = match kind.trim() {
            "layer" => By::Layer(value.to_owned()),
            "id" => By::Id(value.to_owned()),
            "class" => By::Class(value.to_owned()),
            "fill" => By::Fill(value.parse()?),
            "stroke" => By::Stroke(value.parse()?),
            _ => return Err(wrong()),
        };
        Ok(Self { text: text.to_owned(), by })
    }
}

impl fmt::Display for Selector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl FromStr for Paint {
    type Err = SelectorError;

    fn from_str(text: &str) -> Result<Self, SelectorError> {
        if text == "none" {
            return Ok(Self::Nothing);
        }
        let color = Color::from_str(text).map_err(|_| SelectorError::Paint(text.to_owned()))?;
        Ok(Self::Rgb(color.red, color.green, color.blue))
    }
}

impl fmt::Display for Paint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => f.write_str("none"),
            Self::Rgb(red, green, blue) => write!(f, "#{red:02x}{green:02x}{blue:02x}"),
            Self::Other => f.write_str("a gradient or pattern"),
        }
    }
}

impl Selector {
    pub(crate) fn is_about_strokes(&self) -> bool {
        matches!(self.by, By::Stroke(_))
    }

    pub(crate) fn chooses(&self, shape: &Traits) -> bool {
        let any = |names: &BTreeSet<String>, pattern: &str| names.iter().any(|name| fits(pattern, name));
        match &self.by {
            By::Layer(pattern) => any(&shape.layers, pattern),
            By::Id(pattern) => any(&shape.ids, pattern),
            By::Class(pattern) => any(&shape.classes, pattern),
            By::Fill(paint) => shape.fill == Some(*paint),
            By::Stroke(paint) => shape.stroke == Some(*paint),
        }
    }

    /// The error that the selector chooses none of these shapes, with the traits that there are.
    pub(crate) fn chooses_nothing(&self, shapes: &[Traits]) -> Option<String> {
        if shapes.iter().any(|shape| self.chooses(shape)) {
            return None;
        }
        let names = |of: fn(&Traits) -> Vec<String>| shapes.iter().flat_map(of).collect::<BTreeSet<_>>();
        let (what, there) = match self.by {
            By::Layer(_) => ("layers", names(|shape| shape.layers.iter().cloned().collect())),
            By::Id(_) => ("ids", names(|shape| shape.ids.iter().cloned().collect())),
            By::Class(_) => ("classes", names(|shape| shape.classes.iter().cloned().collect())),
            By::Fill(_) => ("fills", names(|shape| shape.fill.iter().map(Paint::to_string).collect())),
            By::Stroke(_) => ("strokes", names(|shape| shape.stroke.iter().map(Paint::to_string).collect())),
        };
        Some(match listed(there.iter()) {
            Some(list) => format!("`{self}` chooses no shape; their {what} are {list}"),
            None => format!("`{self}` chooses no shape; they have no {what}"),
        })
    }
}

/// The first names of many; nothing if there are none.
pub(crate) fn listed<'a>(names: impl ExactSizeIterator<Item = &'a String>) -> Option<String> {
    let count = names.len();
    let first: Vec<_> = names.take(MOST_LISTED).map(|name| format!("`{name}`")).collect();
    let rest = if count > first.len() { format!(" and {} more", count - first.len()) } else { String::new() };
    (count > 0).then(|| first.join(", ") + &rest)
}

/// Whether the name fits the pattern, in which `*` stands for anything.
fn fits(pattern: &str, name: &str) -> bool {
    let Some((head, tail)) = pattern.split_once('*') else { return pattern == name };
    let Some(rest) = name.strip_prefix(head) else { return false };
    let starts = rest.char_indices().map(|(i, _)| i).chain([rest.len()]);
    starts.into_iter().any(|i| fits(tail, &rest[i..]))
}

const MOST_LISTED: usize = 12;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn selectors_are_read_and_refused() {
        assert!("layer=Walls *".parse::<Selector>().is_ok());
        assert_eq!("stroke=BLACK".parse::<Selector>().unwrap().by, By::Stroke(Paint::Rgb(0, 0, 0)));
        for wrong in ["walls", "layer=", "fill=blackish", "layers=a", "=a"] {
            assert!(wrong.parse::<Selector>().unwrap_err().to_string().starts_with("must be "), "{wrong}");
        }
    }

    #[test]
    fn a_star_stands_for_anything() {
        assert!(fits("wall*", "wall-1") && fits("*1", "wall-1") && fits("w*l*1", "wall-1") && fits("*", ""));
        assert!(!fits("wall", "wall-1") && !fits("*2", "wall-1") && !fits("W*", "wall"));
    }
}

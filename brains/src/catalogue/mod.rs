//! All brains by name, and the text that describes one: `NAME[:PARAMETER=NUMBER,…]`, or `FILE.toml[:PATH=NUMBER,…]` for one
//! that is [described](crate::description) in a file.

mod repertoires;

use baudbot_brain::{Body, Brain, EachRun};
use baudbot_fields::Writes;

pub use crate::kinds::{CatalogueError, Entry, Setting, nearest_first};
use crate::kinds::{KINDS, Kind};
use repertoires::Text;
#[cfg(feature = "program")]
pub(crate) use repertoires::text_of;

/// Makes the brain that `description` describes, such as `wander` or `constant:left=0.5,right=-0.5`, for a
/// robot with this body. If a parameter is set twice, the last counts. When its time goes back, because the world was
/// reset, the brain starts over.
///
/// # Errors
/// Says what is wrong with the description and what would be right, or which sensor the body lacks.
pub fn brain(description: &str, seed: u64, body: &Body) -> Result<Box<dyn Brain + Send>, CatalogueError> {
    let (name, settings) = description.split_once(':').unwrap_or((description, ""));
    if let Some(text) = Text::find(name)? {
        let description = text.read(settings)?;
        let make = move |body: &Body| text.brain(&description, seed, body);
        return Ok(Box::new(EachRun::new(make(body)?, move |body: &Body| make(body).ok())));
    }
    kind(name)?.brain(settings, seed, body)
}

/// Whether there is a brain of this name, or a file. It may still not fit a given robot.
///
/// # Errors
/// See [`brain`].
pub fn check(description: &str) -> Result<(), CatalogueError> {
    let (name, settings) = description.split_once(':').unwrap_or((description, ""));
    match Text::find(name)? {
        Some(text) => text.read(settings).map(drop),
        None => kind(name).map(drop),
    }
}

/// The most frequent writing of the brain that `description` describes.
///
/// # Errors
/// See [`brain`].
pub fn writes(description: &str) -> Result<Writes, CatalogueError> {
    let (name, settings) = description.split_once(':').unwrap_or((description, ""));
    match Text::find(name)? {
        Some(text) => Ok(text.read(settings)?.writes()),
        None => Ok(kind(name)?.entry.writes),
    }
}

/// The text of a brain that is described in TOML, with what is set of it; `None` if the brain is written in Rust.
///
/// # Errors
/// If there is no such file, or what is set cannot be.
pub fn described(description: &str) -> Result<Option<String>, CatalogueError> {
    let (name, settings) = description.split_once(':').unwrap_or((description, ""));
    Text::find(name)?.map(|text| text.edited(settings)).transpose()
}

/// The brain that `description` describes as one C file for a robot with this body: see [`Description::c_file`](crate::description::Description::c_file).
/// One that is written in Rust is exported as a description with this one behaviour.
///
/// # Errors
/// See [`brain`], and what of it cannot be exported.
pub fn c_file(description: &str, seed: u64, body: &Body) -> Result<String, CatalogueError> {
    let (name, settings) = description.split_once(':').unwrap_or((description, ""));
    let text = match Text::find(name)? {
        Some(text) => text,
        None => {
            kind(name)?.brain(settings, seed, body)?;
            Text::of_kind(kind(name)?.entry.name)
        }
    };
    text.c_file(settings, seed, body)
}

/// The name that people see of the brain that `description` describes: as much of it as the contract allows, 64 bytes.
pub fn shown_name(description: &str) -> String {
    description[..description.floor_char_boundary(64)].to_owned()
}

/// Names of what can be set of a brain that is written in Rust; none of one that is described.
pub fn parameters(description: &str) -> Vec<&'static str> {
    let name = description.split(':').next().unwrap_or_default();
    let entry = catalogue().into_iter().find(|entry| entry.name == name);
    entry.iter().flat_map(|entry| &entry.parameters).map(|setting| setting.name).collect()
}

/// Whether a parameter of this name can be set of a brain. Of one that is described each path can be: whether it leads to
/// anything is seen when the brain is made.
pub fn takes(description: &str, parameter: &str) -> bool {
    let name = description.split(':').next().unwrap_or_default();
    let is_path = || parameter.contains('.') && matches!(Text::find(name), Ok(Some(_)));
    parameters(description).contains(&parameter) || is_path()
}

fn kind(name: &str) -> Result<&'static Kind, CatalogueError> {
    KINDS.iter().find(|kind| kind.entry.name == name).ok_or_else(|| {
        let known = nearest_first(name, catalogue().into_iter().map(|entry| entry.name));
        CatalogueError::Brain { name: name.to_owned(), known }
    })
}

/// All kinds of brains, for help texts, in the order of their names.
pub fn catalogue() -> Vec<Entry> {
    let mut all: Vec<_> = KINDS.iter().map(|kind| kind.entry.clone()).chain(repertoires::entries()).collect();
    all.sort_by_key(|entry| entry.name);
    all
}

#[cfg(test)]
mod tests {
    use baudbot_brain::Action;

    use super::*;
    use crate::kinds::PLACED_SCANS;
    use crate::test_body::{body, turn};

    fn error(description: &str) -> String {
        match brain(description, 1, &body(&[("ir_rear", "ir", 3.1)])) {
            Ok(_) => panic!("{description} is a brain"),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn long_names_are_cut_between_letters() {
        assert_eq!(shown_name(&"ä".repeat(40)), "ä".repeat(32));
        assert_eq!(shown_name(&format!("a{}", "ä".repeat(40))).len(), 63);
    }

    #[test]
    fn parameters_are_set() {
        let body = body(&[]);
        let mut constant = brain("constant: left = 0.5, right=-0.25,", 1, &body).unwrap();
        assert_eq!(constant.step(&turn(&body, 0, &[])), Action::drive(0.5, -0.25));
        let mut wander = brain("wander:forward=0.1", 1, &body).unwrap();
        assert_eq!(wander.step(&turn(&body, 0, &[])), Action::drive(0.1, 0.1));
    }

    #[test]
    fn what_is_wrong_is_said_with_what_would_be_right() {
        assert!(error("wonder").starts_with("no brain `wonder`; there are: wander, "));
        assert!(error("").starts_with("no brain ``; there are: "));
        assert_eq!(
            error("constant:rigth=1"),
            "brain `constant` has no parameter `rigth`; it has: right, left"
        );
        assert_eq!(
            error("constant:left"),
            "brain `constant`: `left` does not set a parameter; write NAME=NUMBER"
        );
        assert_eq!(error("constant:left=full"), "brain `constant`: left must be a number, not `full`");
        assert_eq!(
            error("wander:turn_probability=3"),
            "brain `wander`: turn_probability must be from 0 to 1, not 3"
        );
        assert_eq!(error("wander:turn=NaN"), "brain `wander`: turn must be from -10 to 10, not NaN");
    }

    #[test]
    fn brains_say_which_sensors_they_need_together() {
        let together = catalogue().into_iter().filter(|entry| entry.together == PLACED_SCANS);
        let names: Vec<_> = together.map(|entry| entry.name).collect();
        assert_eq!(names, ["errands", "explore", "hall", "mower", "tour"]);
    }

    #[test]
    fn a_missing_sensor_is_named() {
        assert_eq!(
            error("navigate"),
            "brain `navigate` needs a sensor `odometer` with x_m and y_m, but robot `alice` has only: ir_rear"
        );
        assert!(
            error("avoid").starts_with("brain `avoid` needs a sensor of kind `ir` that looks ahead, but")
        );
    }

    #[test]
    fn every_default_is_within_its_range_and_every_brain_can_be_made() {
        let body = body(&[
            ("odometer", "odometer", 0.0),
            ("eye", "ir", 0.0),
            ("nose", "field", 0.0),
            ("laser", "laser", 0.0),
        ]);
        for entry in catalogue() {
            for setting in &entry.parameters {
                assert!(setting.range.contains(&setting.default), "{}: {setting:?}", entry.name);
                let same = format!("{}:{}={}", entry.name, setting.name, setting.default);
                assert!(brain(&same, 1, &body).is_ok(), "{same}");
            }
        }
    }
}

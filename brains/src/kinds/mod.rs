//! The kinds of brains that are written in Rust.

mod error;
mod nearest;

use std::ops::RangeInclusive;
use std::sync::LazyLock;

use baudbot_brain::{Body, Brain, EachRun};
use baudbot_fields::Writes;

pub use error::CatalogueError;
pub use nearest::nearest_first;

use crate::animals::ant::brain::{self as ant, AntBrain};
use crate::animals::ecoli::brain::{self as ecoli, EColiBrain};
use crate::animals::larva::brain::{self as larva, LarvaBrain};
use crate::animals::stentor::brain::{self as stentor, StentorBrain};
use crate::animals::woodlice::brain::{self as woodlice, WoodlouseBrain};
use crate::chance::Chance;
use crate::exploration::brain as explore;
use crate::parameter::Parameter;
use crate::{Avoid, Constant, Explore, Navigate, Wander, avoid, constant, navigate, wander};

/// A kind of brain.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The brain's name.
    pub name: &'static str,
    /// The brain's description, in a line.
    pub summary: String,
    /// The most frequent writing, which a budget assumes.
    pub writes: Writes,
    /// The settings; a brain that is described in TOML has any number of them, by their paths.
    pub parameters: Vec<Setting>,
    /// Two kinds of sensors that it needs together: readings of the first are of no use before those of the second have come
    /// that cover their instants.
    pub together: Option<[&'static str; 2]>,
}

/// A parameter of a kind of brain.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// The setting's name.
    pub name: &'static str,
    /// The meaning of the setting, with its unit.
    pub meaning: &'static str,
    /// The setting's default.
    pub default: f64,
    /// The values that it can be set to.
    pub range: RangeInclusive<f64>,
}

/// A kind of brain, and how one is made.
pub(crate) struct Kind {
    pub(crate) entry: Entry,
    make: Box<Make>,
}

type Make = dyn Fn(&BrainRequest<'_>) -> Result<Box<dyn Brain + Send>, CatalogueError> + Send + Sync;

/// A brain that is to be made.
struct BrainRequest<'a> {
    brain: &'static str,
    /// `PARAMETER=NUMBER,…`.
    settings: &'a str,
    seed: u64,
    body: &'a Body,
}

/// All of them, in the order of their names.
pub(crate) static KINDS: LazyLock<Vec<Kind>> = LazyLock::new(|| {
    vec![
        Kind::sensing(
            "ant",
            "goes out on a winding path, and returns by its home vector and by remembered landmarks",
            ant::PARAMETERS,
            AntBrain::new,
            "a sensor of kind `laser` whose sweep is in the data sheet, and a sensor of kind `odometer`",
        ),
        Kind::sensing(
            "avoid",
            "wanders, and avoids what its infrared sensors detect",
            avoid::PARAMETERS,
            Avoid::new,
            "a sensor of kind `ir` that looks ahead",
        ),
        Kind::new("constant", "sends constant motor signals", constant::PARAMETERS, |parameters, _| {
            Ok(Box::new(Constant::new(parameters)))
        }),
        Kind::sensing(
            "ecoli",
            "seeks more of what it senses as E. coli does: runs while it gets better, tumbles if not",
            ecoli::PARAMETERS,
            EColiBrain::new,
            "a sensor of kind `field`, `light` or `photoresistor`",
        ),
        explore_kind(),
        Kind::sensing(
            "larva",
            "crawls away from light like a fly's larva, swinging its head, until the reflex tires",
            larva::PARAMETERS,
            LarvaBrain::new,
            "a sensor of kind `light`, `photoresistor` or `field`",
        ),
        Kind::new(
            "navigate",
            "drives a distance by its odometer and stops",
            navigate::PARAMETERS,
            |parameters, request| {
                let odometer = request.body.sensor(navigate::ODOMETER);
                let odometer = odometer.filter(|sensor| sensor.components.len() >= 2);
                odometer.ok_or_else(|| request.lacks("a sensor `odometer` with x_m and y_m"))?;
                Ok(Box::new(Navigate::new(parameters)))
            },
        ),
        Kind::sensing(
            "stentor",
            "sits still; when disturbed it turns away, backs off, contracts and finally drives off",
            stentor::PARAMETERS,
            StentorBrain::new,
            "a sensor of kind `field`, `light`, `photoresistor`, `bumper` or `ir`",
        ),
        Kind::new(
            "wander",
            "drives straight and turns at random times, without sensors",
            wander::PARAMETERS,
            |parameters, request| Ok(Box::new(Wander::new(parameters, request.chance()))),
        ),
        Kind::sensing(
            "woodlouse",
            "runs fast where it is dry and slowly where it is damp, and so stays where it is damp",
            woodlice::PARAMETERS,
            WoodlouseBrain::new,
            "a sensor of kind `field`, `light` or `photoresistor`",
        ),
    ]
});

fn explore_kind() -> Kind {
    let mut kind = Kind::new(
        "explore",
        "explores until its laser has seen every part of the floor",
        explore::PARAMETERS,
        |parameters, request| {
            let needed = "a sensor of kind `laser` whose sweep is in the data sheet, with two rays or more, and a sensor \
                          `odometer` with x_m, y_m and heading_rad";
            let explore = Explore::new(parameters, request.body);
            Ok(Box::new(explore.ok_or_else(|| request.lacks(needed))?))
        },
    );
    kind.entry.together = PLACED_SCANS;
    kind
}

impl Kind {
    fn new<P: Default + 'static>(
        name: &'static str,
        summary: &str,
        parameters: &'static [Parameter<P>],
        make: impl Fn(P, &BrainRequest<'_>) -> Result<Box<dyn Brain + Send>, CatalogueError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        let entry = Entry {
            name,
            summary: summary.to_owned(),
            writes: Writes::WhenFree,
            parameters: settings(parameters),
            together: None,
        };
        Self { entry, make: Box::new(move |request| make(request.parameters(parameters)?, request)) }
    }

    /// A brain that cannot be without some sensors.
    fn sensing<P: Default + 'static, B: Brain + Send + 'static>(
        name: &'static str,
        summary: &str,
        parameters: &'static [Parameter<P>],
        new: fn(P, Chance, &Body) -> Option<B>,
        needed: &'static str,
    ) -> Self {
        Self::new(name, summary, parameters, move |parameters, request| {
            let brain = new(parameters, request.chance(), request.body);
            Ok(Box::new(brain.ok_or_else(|| request.lacks(needed))?))
        })
    }

    /// Makes one for a robot with this body, with `PARAMETER=NUMBER,…`. It starts over when its time goes back.
    pub(crate) fn brain(
        &'static self,
        settings: &str,
        seed: u64,
        body: &Body,
    ) -> Result<Box<dyn Brain + Send>, CatalogueError> {
        let settings = settings.to_owned();
        let make = move |body: &Body| {
            (self.make)(&BrainRequest { brain: self.entry.name, settings: &settings, seed, body })
        };
        Ok(Box::new(EachRun::new(make(body)?, move |body: &Body| make(body).ok())))
    }
}

/// Brains that make maps of scans, or localize themselves by scans, must know where each was taken.
pub(crate) const PLACED_SCANS: Option<[&str; 2]> = Some(["laser", "odometer"]);

fn settings<P: Default>(parameters: &[Parameter<P>]) -> Vec<Setting> {
    let mut defaults = P::default();
    let setting = |parameter: &Parameter<P>| Setting {
        name: parameter.name,
        meaning: parameter.meaning,
        default: *(parameter.field)(&mut defaults),
        range: parameter.range.clone(),
    };
    parameters.iter().map(setting).collect()
}

impl BrainRequest<'_> {
    fn chance(&self) -> Chance {
        Chance::new(self.seed, &format!("{}/{}", self.body.name, self.brain))
    }

    fn lacks(&self, needed: &'static str) -> CatalogueError {
        CatalogueError::Sensor {
            brain: self.brain,
            robot: self.body.name.clone(),
            needed,
            found: self.body.sensors.iter().map(|sensor| sensor.name.clone()).collect(),
        }
    }

    /// The default parameters with the changes that the settings make.
    fn parameters<P: Default>(&self, known: &[Parameter<P>]) -> Result<P, CatalogueError> {
        let (brain, settings) = (self.brain, self.settings);
        let mut parameters = P::default();
        for setting in settings.split(',').map(str::trim).filter(|setting| !setting.is_empty()) {
            let no_setting = || CatalogueError::Setting { brain, found: setting.to_owned() };
            let (name, value) = setting.split_once('=').ok_or_else(no_setting)?;
            let (name, value) = (name.trim(), value.trim());
            let Some(parameter) = known.iter().find(|parameter| parameter.name == name) else {
                let known = nearest_first(name, known.iter().map(|parameter| parameter.name));
                return Err(CatalogueError::Parameter { brain, name: name.to_owned(), known });
            };
            let parameter_name = parameter.name;
            let no_number =
                |_| CatalogueError::Number { brain, parameter: parameter_name, found: value.to_owned() };
            let found = value.parse().map_err(no_number)?;
            if !parameter.range.contains(&found) {
                let range = parameter.range.clone();
                return Err(CatalogueError::Range { brain, parameter: parameter_name, range, found });
            }
            *(parameter.field)(&mut parameters) = found;
        }
        Ok(parameters)
    }
}

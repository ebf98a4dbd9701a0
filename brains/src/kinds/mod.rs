//! The kinds of brains that are written in Rust.

mod error;
mod nearest;

use std::ops::RangeInclusive;

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
    /// Its name.
    pub name: &'static str,
    /// Its description, in a line.
    pub summary: String,
    /// When it writes, at most: what a budget takes for granted of it.
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
    /// Its name.
    pub name: &'static str,
    /// Its meaning, with its unit.
    pub meaning: &'static str,
    /// Its value if it is not set.
    pub default: f64,
    /// The values that it can be set to.
    pub range: RangeInclusive<f64>,
}

/// A kind of brain, and how one is made.
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    pub(crate) writes: Writes,
    summary: &'static str,
    settings: fn() -> Vec<Setting>,
    make: fn(&BrainRequest<'_>) -> Result<Box<dyn Brain + Send>, CatalogueError>,
    together: Option<[&'static str; 2]>,
}

/// A brain that is to be made.
struct BrainRequest<'a> {
    brain: &'static str,
    /// `PARAMETER=NUMBER,…`.
    settings: &'a str,
    seed: u64,
    body: &'a Body,
}

/// All of them, in the order of their names.
pub(crate) const KINDS: &[Kind] = &[
    Kind {
        name: "ant",
        writes: Writes::WhenFree,
        summary: "goes out on a winding path, and returns by its home vector and by remembered landmarks",
        settings: || settings(ant::PARAMETERS),
        make: |request| {
            request.sensing(
                ant::PARAMETERS,
                AntBrain::new,
                "a sensor of kind `laser` that tells how it sweeps, and a sensor of kind `odometer`",
            )
        },
        together: None,
    },
    Kind {
        name: "avoid",
        writes: Writes::WhenFree,
        summary: "wanders without running into what its infra-red sensors see",
        settings: || settings(avoid::PARAMETERS),
        make: |request| {
            request.sensing(avoid::PARAMETERS, Avoid::new, "a sensor of kind `ir` that looks ahead")
        },
        together: None,
    },
    Kind {
        name: "constant",
        writes: Writes::WhenFree,
        summary: "sends the same signals all the time",
        settings: || settings(constant::PARAMETERS),
        make: |request| Ok(Box::new(Constant::new(request.parameters(constant::PARAMETERS)?))),
        together: None,
    },
    Kind {
        name: "ecoli",
        writes: Writes::WhenFree,
        summary: "seeks more of what it senses as E. coli does: runs while it gets better, tumbles if not",
        settings: || settings(ecoli::PARAMETERS),
        make: |request| {
            request.sensing(
                ecoli::PARAMETERS,
                EColiBrain::new,
                "a sensor of kind `field`, `light` or `photoresistor`",
            )
        },
        together: None,
    },
    Kind {
        name: "explore",
        writes: Writes::WhenFree,
        summary: "explores until its laser has seen every part of the floor",
        settings: || settings(explore::PARAMETERS),
        make: |request| {
            let explore = Explore::new(request.parameters(explore::PARAMETERS)?, request.body);
            let needed = "a sensor of kind `laser` that tells how it sweeps, over two rays or more, and a sensor \
                          `odometer` with x_m, y_m and heading_rad";
            Ok(Box::new(explore.ok_or_else(|| request.lacks(needed))?))
        },
        together: PLACED_SCANS,
    },
    Kind {
        name: "larva",
        writes: Writes::WhenFree,
        summary: "crawls away from light like a fly's larva, swinging its head, until the reflex tires",
        settings: || settings(larva::PARAMETERS),
        make: |request| {
            request.sensing(
                larva::PARAMETERS,
                LarvaBrain::new,
                "a sensor of kind `light`, `photoresistor` or `field`",
            )
        },
        together: None,
    },
    Kind {
        name: "navigate",
        writes: Writes::WhenFree,
        summary: "drives a distance by its odometer and stops",
        settings: || settings(navigate::PARAMETERS),
        make: |request| {
            let parameters = request.parameters(navigate::PARAMETERS)?;
            let odometer = request.body.sensor(navigate::ODOMETER);
            let odometer = odometer.filter(|sensor| sensor.components.len() >= 2);
            odometer.ok_or_else(|| request.lacks("a sensor `odometer` with x_m and y_m"))?;
            Ok(Box::new(Navigate::new(parameters)))
        },
        together: None,
    },
    Kind {
        name: "stentor",
        writes: Writes::WhenFree,
        summary: "sits still; when disturbed it turns away, backs off, contracts and finally drives off",
        settings: || settings(stentor::PARAMETERS),
        make: |request| {
            request.sensing(
                stentor::PARAMETERS,
                StentorBrain::new,
                "a sensor of kind `field`, `light`, `photoresistor`, `bumper` or `ir`",
            )
        },
        together: None,
    },
    Kind {
        name: "wander",
        writes: Writes::WhenFree,
        summary: "drives on and turns now and then, blindly and at random",
        settings: || settings(wander::PARAMETERS),
        make: |request| Ok(Box::new(Wander::new(request.parameters(wander::PARAMETERS)?, request.chance()))),
        together: None,
    },
    Kind {
        name: "woodlouse",
        writes: Writes::WhenFree,
        summary: "runs fast where it is dry and slowly where it is damp, and so stays where it is damp",
        settings: || settings(woodlice::PARAMETERS),
        make: |request| {
            request.sensing(
                woodlice::PARAMETERS,
                WoodlouseBrain::new,
                "a sensor of kind `field`, `light` or `photoresistor`",
            )
        },
        together: None,
    },
];

impl Kind {
    pub(crate) fn entry(&self) -> Entry {
        Entry {
            name: self.name,
            writes: self.writes,
            summary: self.summary.to_owned(),
            parameters: (self.settings)(),
            together: self.together,
        }
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
            (self.make)(&BrainRequest { brain: self.name, settings: &settings, seed, body })
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

    /// A brain that cannot be without some sensors.
    fn sensing<P: Default, B: Brain + Send + 'static>(
        &self,
        known: &[Parameter<P>],
        new: fn(P, Chance, &Body) -> Option<B>,
        needed: &'static str,
    ) -> Result<Box<dyn Brain + Send>, CatalogueError> {
        let brain = new(self.parameters(known)?, self.chance(), self.body);
        Ok(Box::new(brain.ok_or_else(|| self.lacks(needed))?))
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

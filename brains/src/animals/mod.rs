//! Animals as models for robots: Wahde 2016, chapter 4 and §7.2.1.
//!
//! | animal | shows | from |
//! |---|---|---|
//! | [`ecoli`] | chemotaxis with a memory, by choosing between two behaviours | §4.4.2, (4.1) |
//! | [`stentor`] | choosing one of five behaviours by utility | (7.11)–(7.15) |
//! | [`woodlice`] | kinesis: they gather in the damp, where they move little | §4.4.2 |
//! | [`larva`] | taxis away from light, and a reflex that tires | §4.4.1, §4.4.2 |
//! | [`ant`] | path integration, search, and landmarks | §4.4.4 |
//!
//! Each is a small model with a `step`: of what is sensed and of the time since the last step it makes a behaviour
//! or a [`Motion`]. Lengths are in metres and times in seconds, at the scale of a small robot. The notes give
//! equations for the first three and words for the others; where a number is ours, the model says so.
//!
//! [`ecoli::EColiBrain`], [`stentor::StentorBrain`], [`woodlice::WoodlouseBrain`], [`larva::LarvaBrain`] and
//! [`ant::AntBrain`] put such a model into a robot. How a colony of *E. coli* gathers where the attractant is, Fig. 4.2, shows
//! `cargo run -p baudbot-brains --example colony`.

pub mod ant;
pub mod ecoli;
pub mod larva;
pub mod stentor;
pub mod woodlice;

mod leaky_integrator;
mod sense;
#[cfg(test)]
mod test_dish;
mod wheel_commands;

pub use leaky_integrator::LeakyIntegrator;
pub use sense::Sides;
pub use wheel_commands::Motion;

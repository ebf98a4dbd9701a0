//! The page of evidence: it agrees with the presets, and is what the program makes.

mod agreement;
mod page;

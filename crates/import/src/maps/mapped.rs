//! What becomes of a map's file.

use super::marks::Mark;
use super::shape::{FileNote, Shape};

/// What a map becomes.
#[derive(Debug)]
pub(crate) struct Mapped {
    pub(crate) shapes: Vec<Shape>,
    pub(crate) notes: Vec<FileNote>,
    pub(crate) marks: Vec<Mark>,
}

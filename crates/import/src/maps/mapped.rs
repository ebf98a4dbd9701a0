//! The results of reading a map's file.

use super::marks::Mark;
use super::shape::{FileNote, Shape};

/// The result of reading a map.
#[derive(Debug)]
pub(crate) struct Mapped {
    pub(crate) shapes: Vec<Shape>,
    pub(crate) notes: Vec<FileNote>,
    pub(crate) marks: Vec<Mark>,
}

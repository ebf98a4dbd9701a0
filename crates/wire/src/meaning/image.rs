//! Images of a line camera.

use super::text::Count;
use super::{Cut, Meaning};
use crate::line_image::{self, ParseError};

/// An image begins with its two sync bytes, and its header says how long it is: no longer than `room`, or it is none.
pub(super) fn cut(bytes: &[u8], room: usize) -> Cut {
    match line_image::message_len(bytes) {
        Ok(None) => Cut::Wait,
        Ok(Some(len)) if len > room => Cut::After,
        Ok(Some(len)) if bytes.len() < len => Cut::Wait,
        Ok(Some(_)) => Cut::After,
        // Of bytes that begin none, those before the last are over if the last may begin one.
        Err(ParseError::Sync { skip }) if skip < bytes.len() => Cut::Before,
        Err(_) => Cut::Wait,
    }
}

pub(super) fn read(bytes: &[u8]) -> Meaning {
    match line_image::parse(bytes) {
        Ok(image) => {
            let (columns, rows) = (Count(image.columns.into(), "column"), Count(image.rows.into(), "row"));
            let nearest = image.depths_mm().filter(|&depth_mm| depth_mm > 0).min();
            let mut meaning = Meaning::of(format_args!("image #{}: {columns}, {rows}", image.sequence));
            match nearest {
                Some(depth_mm) => meaning.add(format_args!(", nearest at {depth_mm} mm")),
                None => meaning.add(", no depths"),
            }
            meaning.add(", CRC right");
            meaning
        }
        Err(error) => {
            let mut meaning = Meaning::not_understood(bytes, "damaged image");
            meaning.add(format_args!("; {error}"));
            meaning
        }
    }
}

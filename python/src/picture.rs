//! Pictures as pixels.

use std::sync::{Arc, LazyLock};

use numpy::{IntoPyArray, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{self, Options, Tree, fontdb};

use crate::errors::{apart, failed};

/// The fonts of the system. Without any, pictures have no text.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_system_fonts();
    Arc::new(fonts)
});

/// A picture in SVG as an array of shape (height, width, 3), whose longer side has so many pixels.
#[pyfunction]
pub(crate) fn pixels<'py>(py: Python<'py>, svg: &str, size: u32) -> PyResult<Bound<'py, PyArray3<u8>>> {
    if !(1..=MOST).contains(&size) {
        let problem = format!("render_size: {size} is not a number of pixels; write one from 1 to {MOST}");
        return Err(failed(py, &problem));
    }
    let drawn = apart(py, || drawn(svg, size))?
        .map_err(|error| failed(py, &format!("the picture cannot be drawn: {error}")))?
        .ok_or_else(|| failed(py, "the picture has no size"))?;
    let (height, width) = (drawn.height() as usize, drawn.width() as usize);
    // It is opaque, so that colours are what they are without the share of opacity.
    let colours: Vec<u8> =
        drawn.pixels().iter().flat_map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
    colours.into_pyarray(py).reshape([height, width, 3])
}

/// The picture in pixels; none if it has no size.
fn drawn(svg: &str, size: u32) -> Result<Option<Pixmap>, usvg::Error> {
    let options = Options { fontdb: Arc::clone(&FONTS), ..Options::default() };
    let tree = Tree::from_str(svg, &options)?;
    let longer = tree.size().width().max(tree.size().height());
    let scale = size as f32 / longer;
    let side = |length: f32| ((length * scale).round() as u32).max(1);
    let pixmap = Pixmap::new(side(tree.size().width()), side(tree.size().height()));
    Ok(pixmap.map(|mut pixmap| {
        pixmap.fill(Color::WHITE);
        resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixmap.as_mut());
        pixmap
    }))
}

/// Most pixels of a side.
const MOST: u32 = 8192;

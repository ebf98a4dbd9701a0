//! A folder with files, and what a scenario in it becomes.

use std::borrow::Cow;
use std::path::Path;

use baudbot_geometry::{Point, polygon};
use tempfile::TempDir;

pub(crate) struct Folder(TempDir);

/// A polygon of the text that came out.
#[derive(Debug, PartialEq)]
pub(crate) struct Polygon {
    pub(crate) name: String,
    pub(crate) points: Vec<[f64; 2]>,
    pub(crate) solid: bool,
    pub(crate) closed: bool,
    pub(crate) height_m: Option<f64>,
}

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap())
    }

    pub(crate) fn with(files: &[(&str, &str)]) -> Self {
        files.iter().fold(Self::new(), |folder, (name, text)| folder.file(name, text.as_bytes()))
    }

    pub(crate) fn file(self, name: &str, bytes: &[u8]) -> Self {
        std::fs::write(self.0.path().join(name), bytes).unwrap();
        self
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn inline<'a>(&self, text: &'a str) -> Result<Cow<'a, str>, String> {
        baudbot_import::inline(text, self.path()).map_err(|error| error.to_string())
    }

    /// The message, the folder's own name taken out of it.
    pub(crate) fn refused(&self, text: &str) -> String {
        let message = self.inline(text).expect_err(text);
        assert!(!message.contains('\n'), "more than one line: {message}");
        message.replace(&format!("{}/", self.path().display()), "")
    }

    pub(crate) fn polygons(&self, text: &str) -> Vec<Polygon> {
        polygons(&self.inline(text).unwrap())
    }
}

pub(crate) fn polygons(text: &str) -> Vec<Polygon> {
    let table: toml::Table = text.parse().unwrap_or_else(|error| panic!("{error}\n{text}"));
    let Some(list) = table.get("arena").and_then(|arena| arena.get("polygons")) else { return Vec::new() };
    list.as_array().unwrap().iter().map(polygon).collect()
}

fn polygon(value: &toml::Value) -> Polygon {
    let number = |x: &toml::Value| x.as_float().or_else(|| x.as_integer().map(|x| x as f64)).unwrap();
    let flag = |name| value.get(name).is_none_or(|flag| flag.as_bool().unwrap());
    Polygon {
        name: value["name"].as_str().unwrap().to_owned(),
        points: value["points_m"]
            .as_array()
            .unwrap()
            .iter()
            .map(|point| [number(&point[0]), number(&point[1])])
            .collect(),
        solid: flag("solid"),
        closed: flag("closed"),
        height_m: value.get("height_m").map(number),
    }
}

/// Whether any solid polygon contains the point.
pub(crate) fn is_taken(polygons: &[Polygon], x: f64, y: f64) -> bool {
    polygons.iter().filter(|polygon| polygon.solid).any(|solid| {
        let corners: Vec<_> = solid.points.iter().map(|&[x, y]| Point::new(x, y)).collect();
        polygon::contains(&corners, Point::new(x, y))
    })
}

/// A grey image of 8 bits, its rows from the top.
pub(crate) fn pgm(width: usize, samples: &[u8]) -> Vec<u8> {
    let header = format!("P5\n# by hand\n{width} {}\n255\n", samples.len() / width);
    [header.as_bytes(), samples].concat()
}

pub(crate) fn png(width: usize, samples: &[u8], color: png::ColorType, depth: png::BitDepth) -> Vec<u8> {
    let row = width * color.samples() * if depth == png::BitDepth::Sixteen { 2 } else { 1 };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, (samples.len() / row) as u32);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(samples).unwrap();
    bytes
}

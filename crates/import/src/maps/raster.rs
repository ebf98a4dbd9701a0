//! Images as brightness: PGM and PNG.

use std::error::Error as _;
use std::io::{self, Cursor};
use std::path::Path;

use image::codecs::png::PngDecoder;
use image::codecs::pnm::PnmDecoder;
use image::{ImageDecoder, ImageError, ImageResult};

use crate::error::FileError;
use crate::file;

/// The occupied cells of a map, by rows from the top.
#[derive(Debug)]
pub(crate) struct Bitmap {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) cells: Vec<bool>,
}

/// Reads an image and asks of each pixel whether it is occupied. The question has the pixel's brightness,
/// from 0 (black) to 1, which is the mean of its colours; a pixel that one can see through has none.
pub(crate) fn read(
    path: &Path,
    mut is_occupied: impl FnMut(Option<f64>) -> bool,
) -> Result<Bitmap, FileError> {
    let bytes = file::bytes(path)?;
    let unreadable = |error: ImageError| FileError::new(path, in_words(&error));
    let pixels = if bytes.starts_with(b"P5") || bytes.starts_with(b"P2") {
        let decoder = PnmDecoder::new(Cursor::new(&bytes)).map_err(unreadable)?;
        let brightest = decoder.header().maximal_sample();
        check_size(path, &decoder)?;
        Pixels::decode(decoder, brightest)
    } else if bytes.starts_with(b"\x89PNG") {
        let decoder = PngDecoder::new(Cursor::new(&bytes)).map_err(unreadable)?;
        check_size(path, &decoder)?;
        let is_wide = decoder.color_type().bytes_per_pixel() / decoder.color_type().channel_count() == 2;
        Pixels::decode(decoder, if is_wide { 0xffff } else { 0xff })
    } else {
        let problem = "is neither a grey PGM (P2 or P5) nor a PNG: convert the image to one of them";
        return Err(FileError::new(path, problem));
    };
    let pixels = pixels.map_err(unreadable)?;
    let cells = pixels.bytes.chunks_exact(pixels.channels * pixels.bytes_per_sample);
    let cells = cells.map(|pixel| is_occupied(pixels.brightness(pixel))).collect();
    Ok(Bitmap { width: pixels.width, height: pixels.height, cells })
}

/// The header's claims are checked before anything is decoded: a small file can claim to be a huge image.
fn check_size(path: &Path, decoder: &impl ImageDecoder) -> Result<(), FileError> {
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(FileError::new(
            path,
            format!("has {width} × {height} pixels, and no cell: save the map again"),
        ));
    }
    if width.max(height) <= MAX_SIDE && u64::from(width) * u64::from(height) <= MAX_CELLS {
        return Ok(());
    }
    let problem = format!(
        "has {width} × {height} pixels, the limit is {MAX_SIDE} a side and {MAX_CELLS} in all: use a coarser map"
    );
    Err(FileError::new(path, problem))
}

/// The reason why an image cannot be decoded. The crate's own words name it, and Rust's library.
#[expect(clippy::wildcard_enum_match_arm, reason = "the enum is not exhaustive")]
fn in_words(error: &ImageError) -> String {
    let why = match error {
        ImageError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            Some("it ends before its last pixel".to_owned())
        }
        ImageError::IoError(error) => Some(error.to_string()),
        ImageError::Decoding(error) => error.source().map(ToString::to_string),
        _ => None,
    };
    let why = why.unwrap_or_else(|| "it is of a kind that is not read".to_owned());
    format!("cannot be decoded: {why}; save it again as a grey PGM or a PNG")
}

struct Pixels {
    width: usize,
    height: usize,
    channels: usize,
    /// Whether the last channel is the opacity.
    has_opacity: bool,
    bytes_per_sample: usize,
    /// The sample that means white.
    brightest: f64,
    bytes: Vec<u8>,
}

impl Pixels {
    fn decode(decoder: impl ImageDecoder, brightest: u32) -> ImageResult<Self> {
        let (width, height) = decoder.dimensions();
        let color = decoder.color_type();
        let channels = usize::from(color.channel_count());
        let mut bytes = vec![0; decoder.total_bytes() as usize];
        decoder.read_image(&mut bytes)?;
        Ok(Self {
            width: width as usize,
            height: height as usize,
            channels,
            has_opacity: color.has_alpha(),
            bytes_per_sample: usize::from(color.bytes_per_pixel()) / channels,
            brightest: f64::from(brightest.max(1)),
            bytes,
        })
    }

    fn brightness(&self, pixel: &[u8]) -> Option<f64> {
        let samples = pixel.chunks_exact(self.bytes_per_sample).map(|sample| match *sample {
            [a, b] => f64::from(u16::from_ne_bytes([a, b])),
            _ => f64::from(sample[0]),
        });
        let colors = self.channels - usize::from(self.has_opacity);
        let is_clear = self.has_opacity && samples.clone().next_back() != Some(self.brightest);
        let mean = samples.take(colors).sum::<f64>() / colors as f64;
        (!is_clear).then(|| (mean / self.brightest).min(1.0))
    }
}

const MAX_SIDE: u32 = 16_384;
const MAX_CELLS: u64 = 64 << 20;

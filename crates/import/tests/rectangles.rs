//! The rectangles of a map are its occupied cells, each of them once.

use crate::common::{Folder, pgm};
use proptest::prelude::*;

const YAML: &str = "image: map.pgm\nresolution: 1.0\norigin: [0, 0, 0]\nnegate: 0\n";
const SCENARIO: &str = "[[arena.maps]]\nname = \"map\"\nros = \"map.yaml\"\n";

/// The number of rectangles that cover each cell, by rows from the top.
fn covered(width: usize, cells: &[bool]) -> Vec<usize> {
    let height = cells.len() / width;
    let samples: Vec<u8> = cells.iter().map(|&is_occupied| if is_occupied { 0 } else { 255 }).collect();
    let folder = Folder::with(&[("map.yaml", YAML)]).file("map.pgm", &pgm(width, &samples));
    let mut counts = vec![0; cells.len()];
    for polygon in folder.polygons(SCENARIO) {
        let [[left, bottom], [right, b], [r, top], [l, t]] = polygon.points.try_into().unwrap();
        assert_eq!((left, right, bottom, top), (l, r, b, t), "sides along the axes");
        assert!(polygon.solid && polygon.closed);
        for row in height - top as usize..height - bottom as usize {
            for column in left as usize..right as usize {
                counts[row * width + column] += 1;
            }
        }
    }
    counts
}

fn bitmaps() -> impl Strategy<Value = (usize, Vec<bool>)> {
    (1..24_usize, 1..24_usize, 0.0..=1.0_f64).prop_flat_map(|(width, height, share)| {
        (Just(width), proptest::collection::vec(proptest::bool::weighted(share), width * height))
    })
}

proptest! {
    #[test]
    fn they_cover_what_is_occupied_once_and_nothing_else((width, cells) in bitmaps()) {
        let expected: Vec<usize> = cells.iter().map(|&is_occupied| usize::from(is_occupied)).collect();
        prop_assert_eq!(covered(width, &cells), expected);
    }
}

#[test]
fn a_full_map_is_one_rectangle_and_an_empty_one_none() {
    let count = |sample: u8| {
        let folder = Folder::with(&[("map.yaml", YAML)]).file("map.pgm", &pgm(50, &[sample; 50 * 20]));
        folder.polygons(SCENARIO).len()
    };
    assert_eq!((count(0), count(255)), (1, 0));
}

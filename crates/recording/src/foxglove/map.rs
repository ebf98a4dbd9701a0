//! Maps that brains publish, as coloured cells.

use baudbot_proto::v1;
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{Grid, PackedElementField, Vector2};

use super::palette::BELIEF;
use super::parts::{WORLD, pose_at, time};

/// The value of a cell that is certainly occupied.
const OCCUPIED: u8 = 254;
/// The value of an unknown cell.
const UNKNOWN: u8 = 255;

/// None if it is no map.
pub(super) fn grid(map: &v1::GridMap, time_ns: u64) -> Option<Grid> {
    let columns = map.columns as usize;
    let rows = map.cells.len().checked_div(columns)?;
    let sound = [map.x_m, map.y_m, map.cell_m].iter().all(|value| value.is_finite()) && map.cell_m > 0.0;
    // The half millimetre keeps it under zones and over the grid that Foxglove draws.
    let pose = pose_at(map.x_m, map.y_m, 0.0005);
    let data: Vec<u8> = map.cells[..rows * columns].iter().flat_map(|&cell| paint(cell)).collect();
    let row_stride = u32::try_from(columns * CELL_BYTES).ok()?;
    (sound && rows > 0).then(|| Grid {
        timestamp: Some(time(time_ns)),
        frame_id: WORLD.to_owned(),
        pose: Some(pose),
        column_count: map.columns,
        cell_size: Some(Vector2 { x: map.cell_m, y: map.cell_m }),
        row_stride,
        cell_stride: CELL_BYTES as u32,
        fields: fields(),
        data: data.into(),
    })
}

/// One cell of which nothing is seen.
pub(super) fn nothing(time_ns: u64) -> Grid {
    let blank = v1::GridMap { cell_m: 0.001, columns: 1, cells: vec![0], ..v1::GridMap::default() };
    grid(&blank, time_ns).expect("a map of one cell is one")
}

/// Red, green, blue and how much of it.
const CELL_BYTES: usize = 4;

/// The colour of a cell: free ones are clear, occupied ones have the colour of beliefs, and unknown ones are a little
/// grey.
fn paint(cell: u8) -> [u8; CELL_BYTES] {
    if cell == UNKNOWN {
        return [128, 134, 146, 60];
    }
    let alpha = 200 * u32::from(cell) / u32::from(OCCUPIED);
    if alpha == 0 { [0; CELL_BYTES] } else { [BELIEF[0], BELIEF[1], BELIEF[2], alpha as u8] }
}

/// The names by which Foxglove takes the bytes for colours.
fn fields() -> Vec<PackedElementField> {
    let field = |(offset, name): (u32, &str)| PackedElementField {
        name: name.to_owned(),
        offset,
        r#type: NumericType::Uint8.into(),
    };
    (0..).zip(["red", "green", "blue", "alpha"]).map(field).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(columns: u32, cells: &[u8]) -> v1::GridMap {
        v1::GridMap { x_m: -1.0, y_m: -2.0, cell_m: 0.5, columns, cells: cells.to_vec() }
    }

    #[test]
    fn cells_keep_their_places_and_are_coloured_by_what_is_believed() {
        let grid = grid(&map(2, &[0, 254, 255, 127, 9]), 0).unwrap();
        assert_eq!(grid.pose.unwrap().position.unwrap().x, -1.0);
        assert_eq!((grid.column_count, grid.row_stride, grid.cell_stride), (2, 8, 4));
        assert_eq!(grid.cell_size.unwrap(), Vector2 { x: 0.5, y: 0.5 });
        let cells: Vec<_> = grid.data.chunks(4).collect();
        let [r, g, b] = BELIEF;
        assert_eq!(
            cells,
            [[0, 0, 0, 0], [r, g, b, 200], [128, 134, 146, 60], [r, g, b, 100]],
            "and no half row"
        );
        let names: Vec<_> = grid.fields.iter().map(|field| (field.name.as_str(), field.offset)).collect();
        assert_eq!(names, [("red", 0), ("green", 1), ("blue", 2), ("alpha", 3)]);
    }

    #[test]
    fn what_is_no_map_is_none() {
        assert!(grid(&map(0, &[1, 2]), 0).is_none());
        assert!(grid(&map(3, &[1, 2]), 0).is_none());
        assert!(grid(&map(u32::MAX, &[1]), 0).is_none());
        assert!(grid(&v1::GridMap { cell_m: f64::NAN, ..map(1, &[1]) }, 0).is_none());
        assert!(grid(&v1::GridMap { cell_m: 0.0, ..map(1, &[1]) }, 0).is_none());
    }
}

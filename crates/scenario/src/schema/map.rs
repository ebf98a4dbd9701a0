//! A map in another file. The program puts polygons in its place before a scenario is read, so that no type of this crate reads it.

use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec::Vec;

use baudbot_fields::number::{Coordinate, Length, Number, UpTo};

/// The fields of a map.
#[derive(schemars::JsonSchema)]
#[schemars(deny_unknown_fields)]
#[allow(dead_code, reason = "its schema is what it is for")]
pub(super) struct Map {
    /// Unique among the maps. Range: 1 to 40 letters, digits, `_` or `-`.
    name: String,
    /// The YAML file of a map of ROS's `map_server`, with its image in PGM or PNG. Occupied cells become solid
    /// rectangles. Default: this or `svg`.
    ros: Option<String>,
    /// Treatment of the map's unknown cells. `occupied` warns if there are none. Default: `"free"`. Range: only with
    /// `ros`.
    unknown: Option<Unknown>,
    /// A plan in SVG. Filled shapes become solid; other lines become walls without thickness. Default: this or
    /// `ros`.
    svg: Option<String>,
    /// Metres per unit of the drawing. Default: required with `svg`.
    m_per_unit: Option<Number<UpTo<1_000_000>>>,
    /// Position of the drawing's lower left corner. Type: `[x, y]`. Default: `[0, 0]`. Range: each −10^6 to
    /// 10^6; only with `svg`.
    origin_m: Option<[Number<Coordinate>; 2]>,
    /// Maximum distance of a straight segment from the curve that it approximates. Default: 0.005. Range: only
    /// with `svg`.
    tolerance_m: Option<Number<Length>>,
    /// Selectors of the shapes that are walls. Each is `layer=NAME`, `id=NAME`, `class=NAME`, `fill=COLOR` or
    /// `stroke=COLOR`; `*` matches any part of a name, and `none` means no colour. Default: all. Range: only with
    /// `svg`.
    only: Option<Vec<String>>,
    /// Selectors of the shapes that are not walls, as in `only`. Default: none. Range: only with `svg`.
    without: Option<Vec<String>>,
    /// Starts of robots: each robot's name with the id of the shape at whose centre it starts. Type: table. Default:
    /// none. Range: only with `svg`.
    starts: Option<BTreeMap<String, String>>,
    /// The id of a shape that becomes `end.goal`: a disc in its middle, as wide as the smaller of its sides. Default: none. Range: only
    /// with `svg`.
    goal: Option<String>,
    /// Height of the whole map. Default: unlimited.
    height_m: Option<f64>,
}

/// How unknown cells are treated.
#[derive(schemars::JsonSchema)]
#[schemars(rename_all = "kebab-case")]
#[allow(dead_code, reason = "its schema is what it is for")]
enum Unknown {
    Free,
    Occupied,
}

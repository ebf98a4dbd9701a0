//! Options of what is on a pin: which mean something for which part.

use alloc::format;

use baudbot_board::{BridgeKind, Kind};
use baudbot_fields::Path;
use baudbot_sim::chip::Attached;

use super::Result;
use crate::pins::Options;

/// Refuses options of a connection that mean nothing for its part; `is_floor`: it is a reflectance sensor.
pub(super) fn check(
    path: &Path,
    options: &Options,
    (kind, attached): (&Kind, &Attached),
    is_floor: bool,
) -> Result<()> {
    let is_switch = matches!(kind, Kind::Switch(_));
    let known = if let Attached::Comparator(_) = attached {
        &["volts_at_0", "volts_per_unit", "threshold_v", "hysteresis_v", "low_when"]
    } else if let Attached::Control(_) = attached {
        if is_switch { &["pull", "bounce_ms"][..] } else { &[] }
    } else {
        known(kind, is_floor)
    };
    let Some(other) = options.given().find(|name| !known.contains(name)) else { return Ok(()) };
    let what = &options.to;
    let problem = match known {
        [] => format!("does not apply to `{what}`, which has no options"),
        [one] => format!("does not apply to `{what}`, which has the option {one}"),
        [many @ .., last] => {
            format!("does not apply to `{what}`, which has the options {} and {last}", many.join(", "))
        }
    };
    Err(path.field(other).error(problem))
}

const fn known(kind: &Kind, is_floor: bool) -> &'static [&'static str] {
    match kind {
        Kind::Voltage(_) if is_floor => &["volts_at_0", "volts_per_unit", "divider", "rc", "threshold_v"],
        Kind::Voltage(_) => &["volts_at_0", "volts_per_unit", "divider", "threshold_v"],
        Kind::Reflectance(_) => &["rc"],
        Kind::Switch(_) => &["pull"],
        Kind::Bridge(BridgeKind::Directed { .. }) => &["decay", "drop_v"],
        Kind::Bridge(BridgeKind::Shield { .. }) => &["channel", "drop_v"],
        Kind::Bridge(BridgeKind::L298N { .. } | BridgeKind::Tb6612 { .. }) => &["drop_v"],
        Kind::Led(_) => &["lit_by"],
        Kind::Encoder(_)
        | Kind::Ping(_)
        | Kind::HcSr04(_)
        | Kind::Servo(_)
        | Kind::Piezo(_)
        | Kind::Compass(_)
        | Kind::RangeFinder(_) => &[],
    }
}

impl Options {
    /// The names of those that are given.
    fn given(&self) -> impl Iterator<Item = &'static str> + use<> {
        let given = given!(self; volts_at_0, volts_per_unit, divider, threshold_v, hysteresis_v, low_when, bounce_ms, pull, channel, drop_v, decay, lit_by, rc);
        given.into_iter().filter(|(_, is_given)| *is_given).map(|(name, _)| name)
    }
}

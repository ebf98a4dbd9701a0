//! The uses of a zone: their colours and their words.

use baudbot_sim::surroundings::Zone;

use super::FRAME;

/// The purpose of a zone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ZoneUses {
    /// Robots are to reach it.
    pub goal: bool,
    /// Power at which a battery is charged, in watts.
    pub charger_w: f64,
    /// Share of its rolling that a wheel loses, in [0, 1].
    pub slip: f64,
    /// Turn of compasses, in radians.
    pub compass_offset_rad: f64,
    /// The sky is hidden.
    pub indoors: bool,
    /// Reflectance of the floor, if it differs, in [0, 1].
    pub floor: Option<f64>,
}

impl ZoneUses {
    /// The colour of the first use; [`FRAME`] without any.
    pub fn color(&self) -> &'static str {
        self.all().into_iter().find(|(is_used, ..)| *is_used).map_or(FRAME, |(_, color, _)| color)
    }

    /// All uses in words.
    pub fn words(&self) -> Vec<String> {
        let used = self.all().into_iter().filter(|(is_used, ..)| *is_used).map(|(.., words)| words);
        used.chain(self.floor.map(|floor| format!("floor {floor}"))).collect()
    }

    fn all(&self) -> [(bool, &'static str, String); 5] {
        [
            (self.goal, "#0072b2", "goal".to_owned()),
            (self.charger_w > 0.0, "#009e73", format!("charger {} W", self.charger_w)),
            (self.slip > 0.0, "#56b4e9", format!("slippery {}", self.slip)),
            (self.compass_offset_rad != 0.0, "#cc79a7", format!("compass {:+} rad", self.compass_offset_rad)),
            (self.indoors, "#882255", "indoors".to_owned()),
        ]
    }
}

impl From<&Zone> for ZoneUses {
    fn from(zone: &Zone) -> Self {
        let &Zone { goal, charger_w, slip, compass_offset_rad, indoors, floor, .. } = zone;
        Self { goal, charger_w, slip, compass_offset_rad, indoors, floor }
    }
}

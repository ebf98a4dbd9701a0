//! The meaning of the letters and statuses of SCIP 2.0.
//!
//! Sources: Hokuyo, SCIP 2.0, C-42-03320B; of `GE`, `ME`, `RT`, `RB`, `%ST` and `%SL` hokuyolx 0.9.0.

/// A command.
pub(super) struct Kind {
    pub(super) letters: &'static [u8],
    pub(super) asks: &'static str,
    pub(super) parameters: Parameters,
    /// The values of a scan, and the number of characters of each.
    pub(super) values: Option<(&'static str, usize)>,
}

/// The parameters behind the letters.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Parameters {
    None,
    /// The time mode is one digit.
    TimeMode,
    /// The rate is six digits.
    Rate,
    /// First step, last step, cluster.
    Steps,
    /// The same, scan interval, number of scans.
    Scans,
    /// The parameters are not distinguished.
    Other,
}

const fn kind(letters: &'static [u8], asks: &'static str, parameters: Parameters) -> Kind {
    Kind { letters, asks, parameters, values: None }
}

const fn scans(
    letters: &'static [u8],
    asks: &'static str,
    parameters: Parameters,
    values: (&'static str, usize),
) -> Kind {
    Kind { letters, asks, parameters, values: Some(values) }
}

pub(super) const KINDS: [Kind; 21] = [
    scans(b"GD", "distances", Parameters::Steps, ("distance", 3)),
    scans(b"GS", "distances in two characters", Parameters::Steps, ("distance", 2)),
    scans(b"GE", "distances and intensities", Parameters::Steps, ("distance and intensity pair", 6)),
    scans(b"MD", "measure distances", Parameters::Scans, ("distance", 3)),
    scans(b"MS", "measure distances in two characters", Parameters::Scans, ("distance", 2)),
    scans(b"ME", "measure distances and intensities", Parameters::Scans, ("distance and intensity pair", 6)),
    kind(b"VV", "ask version", Parameters::None),
    kind(b"PP", "ask parameters of the sensor", Parameters::None),
    kind(b"II", "ask state of the sensor", Parameters::None),
    kind(b"BM", "laser on", Parameters::None),
    kind(b"QT", "laser off, end of scans", Parameters::None),
    kind(b"RS", "reset", Parameters::None),
    kind(b"RT", "reset without the bit rate", Parameters::None),
    kind(b"RB", "reboot", Parameters::None),
    kind(b"TM", "time mode", Parameters::TimeMode),
    kind(b"SS", "bit rate", Parameters::Rate),
    kind(b"CR", "motor speed", Parameters::Other),
    kind(b"HS", "sensitivity", Parameters::Other),
    kind(b"DB", "simulate a malfunction", Parameters::Other),
    kind(b"%ST", "ask state", Parameters::None),
    kind(b"%SL", "sleep", Parameters::None),
];

/// The meaning of a status, if it is known.
pub(super) fn status_word(kind: &Kind, status: [u8; 2]) -> Option<&'static str> {
    Some(match (&status, kind.parameters) {
        (b"00", _) => "accepted",
        (b"99", Parameters::Scans) => "scan",
        (b"0E", _) => "no such command",
        (b"01", Parameters::Steps | Parameters::Scans) => "first step is no number",
        (b"02", Parameters::Steps | Parameters::Scans) => "last step is no number",
        (b"03", Parameters::Steps | Parameters::Scans) => "cluster is no number",
        (b"04", Parameters::Steps | Parameters::Scans) => "last step too large",
        (b"05", Parameters::Steps | Parameters::Scans) => "last step before the first",
        (b"06", Parameters::Scans) => "interval is no number",
        (b"07", Parameters::Scans) => "number of scans is no number",
        (b"10", Parameters::Steps) => "laser off",
        (b"01", Parameters::TimeMode) => "no such digit",
        (b"02", Parameters::TimeMode) => "was on",
        (b"03", Parameters::TimeMode) => "was off",
        (b"04", Parameters::TimeMode) => "is off",
        (b"10", Parameters::TimeMode) => "laser on",
        (b"01", Parameters::Rate) => "no number",
        (b"02", Parameters::Rate) => "no such rate",
        (b"03", Parameters::Rate) => "has this rate already",
        (b"02", Parameters::None) if kind.letters == b"BM" => "laser was on",
        (b"10", Parameters::None) if kind.letters == b"BM" => "asleep",
        _ => return None,
    })
}

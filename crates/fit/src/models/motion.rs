//! Commands and motion of a log, as the models of motors need them.

use baudbot_geometry::angle;
use baudbot_sim::motor::Motors;
use baudbot_sim::sensor::Device;

use super::Case;
use super::compass::fresh;
use crate::estimate::Reason;
use crate::log::{Column, Quantity};
use crate::statistics::unwrapped;

/// Commands beside a motion, segment by segment.
#[derive(Clone, Debug)]
pub(crate) struct Motion {
    pub(crate) segments: Vec<Segment>,
    pub(crate) kind: Kind,
}

/// The kind of a motion's measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Forward speed and turn rate.
    Speeds,
    /// The way along the heading, and the heading: of poses, or of wheels that were counted.
    Places,
}

/// Rows without a gap.
#[derive(Clone, Debug, Default)]
pub(crate) struct Segment {
    pub(crate) times_s: Vec<f64>,
    /// Signals of the left and the right motor.
    pub(crate) signals: Vec<[f64; 2]>,
    /// The measured forward motion and turning; NaN in place of a missing value.
    pub(crate) measured: Vec<[f64; 2]>,
}

impl Motion {
    /// The motion of a log: its speeds, else its poses, else its counts.
    pub(crate) fn of(case: &Case<'_>) -> Result<Self, Reason> {
        let time = case.column(Quantity::Time)?;
        let signals = signals(case)?;
        let (measured, kind) = measured(case)?;
        let mut segments = Vec::new();
        for range in &case.log.segments {
            if range.len() >= LEAST_ROWS {
                segments.push(Segment {
                    times_s: time.values[range.clone()].to_vec(),
                    signals: signals[range.clone()].to_vec(),
                    measured: measured[range.clone()].to_vec(),
                });
            }
        }
        let rows = segments.iter().map(|segment| segment.times_s.len()).sum();
        if rows < LEAST_IN_ALL {
            let what = "rows with commands, without a gap".into();
            return Err(Reason::TooFew { what, rows: case.log.len().min(rows), least: LEAST_IN_ALL });
        }
        Ok(Self { segments, kind })
    }

    /// The number of changes of the command.
    pub(crate) fn changes(&self) -> usize {
        let changes =
            |segment: &Segment| segment.signals.windows(2).filter(|pair| pair[0] != pair[1]).count();
        self.segments.iter().map(changes).sum()
    }

    /// Whether any command is not 0.
    pub(crate) fn is_driven(&self) -> bool {
        self.segments.iter().flat_map(|segment| &segment.signals).any(|signals| *signals != [0.0; 2])
    }
}

/// The signals of the rows; a command that is missing is the one before it.
fn signals(case: &Case<'_>) -> Result<Vec<[f64; 2]>, Reason> {
    let pair = |left: Quantity, right: Quantity| Some((case.log.column(left)?, case.log.column(right)?));
    let mut last = [0.0; 2];
    let mut keep = |signals: [f64; 2]| {
        if signals.iter().all(|signal| signal.is_finite()) {
            last = signals.map(|signal| signal.clamp(-1.0, 1.0));
        }
        last
    };
    if let Some((left, right)) = pair(Quantity::CommandLeft, Quantity::CommandRight) {
        let pairs = left.values.iter().zip(&right.values);
        let mut signals: Vec<_> = pairs.map(|(left, right)| keep([*left, *right])).collect();
        if left.header == IN_FORCE {
            signals.rotate_left(1);
            if let [.., before, last] = signals.as_mut_slice() {
                *last = *before;
            }
        }
        return Ok(signals);
    }
    let Some((speed, turn)) = pair(Quantity::CommandSpeed, Quantity::CommandTurnRate) else {
        let needs =
            "commands: `command_left` with `command_right`, or `command_v_m_s` with `command_w_rad_s`".into();
        return Err(Reason::Columns { needs });
    };
    let drive = &case.robot.model.drive;
    let Motors::Velocity(motor) = &drive.motor else {
        let needs = "`command_left` and `command_right`: only motors of kind \"velocity\" have commands that follow from speeds";
        return Err(Reason::Columns { needs: needs.into() });
    };
    let (half_track_m, full) = (drive.half_track_m, motor.full_speed_m_s);
    let of = |(v, w): (&f64, &f64)| keep([(v - w * half_track_m) / full, (v + w * half_track_m) / full]);
    Ok(speed.values.iter().zip(&turn.values).map(of).collect())
}

fn measured(case: &Case<'_>) -> Result<(Vec<[f64; 2]>, Kind), Reason> {
    if let (Some(speed), Some(turn)) = (case.log.column(Quantity::Speed), case.log.column(Quantity::TurnRate))
    {
        let pairs = speed.values.iter().zip(&turn.values).map(|(speed, turn)| [*speed, *turn]);
        return Ok((pairs.collect(), Kind::Speeds));
    }
    if let Some(pose) = Pose::of(case) {
        return Ok((pose.along(), Kind::Places));
    }
    if let Some(wheels) = Wheels::of(case) {
        let drive = &case.robot.model.drive;
        let (r, h) = (drive.wheel_radius_m, drive.half_track_m);
        let of = |[left, right]: &[f64; 2]| [0.5 * r * (left + right), 0.5 * r * (right - left) / h];
        return Ok((wheels.turned_rad.iter().map(of).collect(), Kind::Places));
    }
    let needs = "measured motion: `speed_m_s` with `turn_rate_rad_s`, or `x_m`, `y_m` and `heading_rad`, or counts of wheels";
    Err(Reason::Columns { needs: needs.into() })
}

/// The true poses of a log.
pub(crate) struct Pose<'a> {
    x: &'a Column,
    y: &'a Column,
    heading: &'a Column,
}

impl<'a> Pose<'a> {
    pub(crate) fn of(case: &Case<'a>) -> Option<Self> {
        let column = |quantity| case.log.column(quantity);
        Some(Self { x: column(Quantity::X)?, y: column(Quantity::Y)?, heading: column(Quantity::Heading)? })
    }

    /// The way along the heading since the first row, backwards taken off, and the heading without jumps.
    pub(crate) fn along(&self) -> Vec<[f64; 2]> {
        along(&self.x.values, &self.y.values, &self.heading.values)
    }
}

/// The same of positions and headings. Ways are projected on the mean of two headings; rows without a pose have none.
pub(crate) fn along(x: &[f64], y: &[f64], heading: &[f64]) -> Vec<[f64; 2]> {
    let is_known = |row: usize| x[row].is_finite() && y[row].is_finite() && heading[row].is_finite();
    let rows: Vec<usize> = (0..x.len()).filter(|row| is_known(*row)).collect();
    let headings = unwrapped(&rows.iter().map(|row| heading[*row]).collect::<Vec<_>>());
    let mut ways = vec![[f64::NAN; 2]; x.len()];
    let mut way = 0.0;
    for (i, &row) in rows.iter().enumerate() {
        if let Some(before) = i.checked_sub(1) {
            let middle = headings[before] + 0.5 * angle::wrap(headings[i] - headings[before]);
            let from = rows[before];
            way += (x[row] - x[from]) * middle.cos() + (y[row] - y[from]) * middle.sin();
        }
        ways[row] = [way, headings[i]];
    }
    ways
}

/// The turns of counted wheels.
pub(crate) struct Wheels {
    /// The place of the encoders among the robot's sensors.
    pub(crate) sensor: usize,
    /// The turns of the left and the right wheel, in radians by the counts of a turn.
    pub(crate) turned_rad: Vec<[f64; 2]>,
    /// A count, in radians.
    pub(crate) count_rad: f64,
}

impl Wheels {
    pub(crate) fn of(case: &Case<'_>) -> Option<Self> {
        case.robot.model.sensors.iter().enumerate().find_map(|(sensor, spec)| {
            let Device::Encoders(encoders) = &spec.device else { return None };
            let column = |side| case.log.reading(&format!("{}.{side}", spec.name));
            let (left, right) = (column("left")?, column("right")?);
            let count_rad = std::f64::consts::TAU / f64::from(encoders.counts_per_turn);
            let bits = spec.encodings.first().and_then(|encoding| match encoding {
                baudbot_wire::Encoding::Counter { bits } => Some(*bits),
                baudbot_wire::Encoding::Float64
                | baudbot_wire::Encoding::Level { .. }
                | baudbot_wire::Encoding::Signed { .. } => None,
            });
            let (left, right) = (continued(&left.values, bits), continued(&right.values, bits));
            let both: Vec<f64> = left.iter().zip(&right).map(|(l, r)| l + MIXED * r).collect();
            // Between two reads a row has old counts.
            let mut turned_rad = vec![[f64::NAN; 2]; both.len()];
            for row in fresh(case, &both, spec) {
                turned_rad[row] = [left[row] * count_rad, right[row] * count_rad];
            }
            Some(Self { sensor, turned_rad, count_rad })
        })
    }
}

/// Counts of a register that wraps, as if it did not.
fn continued(counts: &[f64], bits: Option<u8>) -> Vec<f64> {
    let Some(bits) = bits else { return counts.to_vec() };
    let span = 2.0_f64.powi(i32::from(bits));
    let (mut last, mut shift) = (f64::NAN, 0.0);
    let step = |count: &f64| {
        if !last.is_nan() && count.is_finite() {
            shift -= ((count - last) / span).round() * span;
        }
        if count.is_finite() {
            last = *count;
        }
        count + shift
    };
    counts.iter().map(step).collect()
}

/// In the table of a run a row has the signals that were in force in the step before it, so they go with that row.
const IN_FORCE: &str = "left_signal";

/// A segment of fewer rows is left out.
const LEAST_ROWS: usize = 10;

const LEAST_IN_ALL: usize = 30;

/// No number of left counts makes up for one of right counts times this.
const MIXED: f64 = 0.618_033_988_749_895;

//! Speeds of the wheels: from a radius, and from the signals of our own brains.

/// The greatest speed of a wheel in a command, in mm/s; signal 1 (libcreate, CREATE_2_MAX_VEL; the table of commands of
/// the first Create).
pub const FULL_MM_S: f64 = 500.0;

/// The speeds of the left and the right wheel, in mm/s, for a speed of the centre and the radius of its turn to the left, on
/// wheels `track_mm` apart. −32768 and 32767 go straight, −1 turns on the spot clockwise and 1 counter-clockwise, at this speed
/// of the wheels. No wheel is faster than [`FULL_MM_S`]: each is cut by itself (a guess).
pub fn wheels_mm_s(velocity_mm_s: i16, radius_mm: i16, track_mm: f64) -> [f64; 2] {
    let velocity = f64::from(velocity_mm_s);
    let [left, right] = match radius_mm {
        i16::MIN | i16::MAX | 0 => [velocity; 2],
        -1 => [velocity, -velocity],
        1 => [-velocity, velocity],
        _ => {
            let share = track_mm / 2.0 / f64::from(radius_mm);
            [velocity * (1.0 - share), velocity * (1.0 + share)]
        }
    };
    [left, right].map(|speed| speed.clamp(-FULL_MM_S, FULL_MM_S))
}

/// A signal in mm/s, to the nearest, and no faster than [`FULL_MM_S`].
pub fn mm_s(signal: f64) -> i16 {
    let speed = (signal * FULL_MM_S).clamp(-FULL_MM_S, FULL_MM_S);
    (speed + 0.5_f64.copysign(speed)) as i16
}

/// The command of these signals: [`DriveDirect`](super::Command::DriveDirect).
pub fn drive_direct([left, right]: [f64; 2]) -> [u8; 5] {
    let ([a, b], [c, d]) = (mm_s(right).to_be_bytes(), mm_s(left).to_be_bytes());
    [145, a, b, c, d]
}

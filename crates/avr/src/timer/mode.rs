//! The modes of a timer.
//!
//! Source: data sheet, tables *Waveform Generation Mode Bit Description* of Timer/Counter0, 1 and 2.

/// The course of the counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Mode {
    pub(super) slope: Slope,
    pub(super) top: Top,
    /// The point at which a buffered compare value becomes the one that is compared.
    pub(super) update: Update,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slope {
    /// Normal and CTC: up to the top, then 0. TOV is set after MAX.
    Single,
    /// Fast PWM: up to the top, then 0. TOV is set after the top.
    Fast,
    /// Phase-correct, with or without correct frequency: up and down. TOV is set at 0.
    Dual,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Top {
    Fixed(u16),
    CompareA,
    Capture,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Update {
    Immediate,
    Top,
    Bottom,
}

impl Mode {
    const NORMAL_8: Self = Self { slope: Slope::Single, top: Top::Fixed(0xFF), update: Update::Immediate };
    const NORMAL_16: Self = Self { slope: Slope::Single, top: Top::Fixed(0xFFFF), update: Update::Immediate };

    /// The mode of an 8-bit timer by WGM2:0. Reserved modes count as normal.
    pub(super) const fn eight(wgm: u8) -> Self {
        let top = if wgm >= 4 { Top::CompareA } else { Top::Fixed(0xFF) };
        match wgm {
            1 | 5 => Self { slope: Slope::Dual, top, update: Update::Top },
            2 => Self { slope: Slope::Single, top: Top::CompareA, update: Update::Immediate },
            3 | 7 => Self { slope: Slope::Fast, top, update: Update::Bottom },
            _ => Self::NORMAL_8,
        }
    }

    /// The mode of a 16-bit timer by WGM3:0. The reserved mode counts as normal.
    pub(super) const fn sixteen(wgm: u8) -> Self {
        let top = match wgm {
            1 | 5 => Top::Fixed(0xFF),
            2 | 6 => Top::Fixed(0x1FF),
            3 | 7 => Top::Fixed(0x3FF),
            4 | 9 | 11 | 15 => Top::CompareA,
            _ => Top::Capture,
        };
        match wgm {
            1 | 2 | 3 | 10 | 11 => Self { slope: Slope::Dual, top, update: Update::Top },
            8 | 9 => Self { slope: Slope::Dual, top, update: Update::Bottom },
            4 | 12 => Self { slope: Slope::Single, top, update: Update::Immediate },
            5 | 6 | 7 | 14 | 15 => Self { slope: Slope::Fast, top, update: Update::Bottom },
            _ => Self::NORMAL_16,
        }
    }

    /// Whether this is one of the PWM modes.
    pub(super) const fn is_pwm(self) -> bool {
        !matches!(self.slope, Slope::Single)
    }
}

/// The effect of a compare match on its pin: COMnx1:0 in the light of the mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Output {
    Disconnected,
    Toggle,
    /// The output is cleared on a match; in PWM modes set again at the other end.
    Clear,
    /// Set on a match; in PWM modes cleared again at the other end.
    Set,
}

impl Output {
    /// An `Output` by the two bits; `toggles` is whether 01 is not reserved here.
    pub(super) const fn of(com: u8, toggles: bool) -> Self {
        match com & 3 {
            1 if toggles => Self::Toggle,
            2 => Self::Clear,
            3 => Self::Set,
            _ => Self::Disconnected,
        }
    }
}

//! The one door to mathematical functions.
//!
//! The maths libraries of different platforms disagree in the last bits, and a simulation amplifies such
//! differences until two machines show different runs. These are therefore thin wrappers over [`libm`],
//! which is the same code everywhere. (Where `libm` does use an instruction of the processor, as for square
//! roots, the standard for floating-point numbers leaves only one possible result.)

/// The sine of an angle in radians.
#[must_use]
pub fn sin(angle_rad: f64) -> f64 {
    libm::sin(angle_rad)
}

/// The cosine of an angle in radians.
#[must_use]
pub fn cos(angle_rad: f64) -> f64 {
    libm::cos(angle_rad)
}

/// The sine and the cosine, in this order, of an angle in radians.
#[must_use]
pub fn sin_cos(angle_rad: f64) -> (f64, f64) {
    libm::sincos(angle_rad)
}

/// The angle in radians, in [-pi, pi], of the vector (`x`, `y`). Mind the order of the arguments.
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// The non-negative square root; NaN for negative numbers.
#[must_use]
#[inline]
pub fn sqrt(x: f64) -> f64 {
    // The same number, which the standard leaves no choice about; but vectors are made of this one only.
    #[cfg(feature = "simd")]
    return x.sqrt();
    #[cfg(not(feature = "simd"))]
    libm::sqrt(x)
}

/// The length of the vector (`x`, `y`), without overflow on the way.
#[must_use]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// The greatest whole number not above `x`.
#[must_use]
pub fn floor(x: f64) -> f64 {
    libm::floor(x)
}

/// The least whole number not below `x`.
#[must_use]
pub fn ceil(x: f64) -> f64 {
    libm::ceil(x)
}

/// The nearest whole number; halves go away from zero.
#[must_use]
pub fn round(x: f64) -> f64 {
    libm::round(x)
}

/// The remainder of `x` after taking away the nearest multiple of `y`: in [-y/2, y/2], and exact.
#[must_use]
pub fn remainder(x: f64, y: f64) -> f64 {
    libm::remainder(x, y)
}

/// The natural logarithm.
#[must_use]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// The exponential function.
#[must_use]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// The hyperbolic tangent.
#[must_use]
pub fn tanh(x: f64) -> f64 {
    libm::tanh(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// These bits were recorded on x86-64; any other machine must arrive at the same.
    #[test]
    fn bits_are_the_same_on_every_machine() {
        let found = [sin(0.7), cos(0.7), atan2(0.3, -1.9), hypot(0.1, 0.7), ln(0.3), exp(0.3), tanh(0.3)];
        assert_eq!(found.map(f64::to_bits), EXPECTED);
    }

    #[test]
    fn sine_and_cosine_agree_with_their_pair() {
        for angle in [-3.0, -0.5, 0.0, 0.1, 2.0, 40.0] {
            assert_eq!(sin_cos(angle), (sin(angle), cos(angle)));
        }
    }

    #[test]
    fn whole_numbers() {
        assert_eq!((floor(-1.5), ceil(-1.5), round(-1.5), round(2.5)), (-2.0, -1.0, -2.0, 3.0));
    }

    const EXPECTED: [u64; 7] = [
        0x3fe4_9d6e_6946_19b8,
        0x3fe8_7996_529f_9d93,
        0x4007_e142_d823_22ea,
        0x3fe6_a09e_667f_3bcc,
        0xbff3_4378_fcbd_a721,
        0x3ff5_9905_8c8c_1a96,
        0x3fd2_a4dd_a7d9_14f9,
    ];
}

//! The widest vectors that the processor has, for loops that are worth it.
//!
//! A program is built for the least processor of its kind, whose vectors hold two numbers. With the feature `simd` the
//! loops here are built for wider ones as well, and the processor is asked which it has. The operations are the same,
//! number by number, and so are the bits: nothing is fused or reordered.

/// Changes each number on its own.
pub fn each(values: &mut [f64], change: impl Fn(f64) -> f64) {
    with_vectors(Each { values, change });
}

/// Changes each number with its partner.
pub fn each_with(values: &mut [f64], partners: &[f64], change: impl Fn(f64, f64) -> f64) {
    with_vectors(EachWith { values, partners, change });
}

struct Each<'a, F> {
    values: &'a mut [f64],
    change: F,
}

impl<F: Fn(f64) -> f64> Work for Each<'_, F> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        for value in self.values {
            *value = (self.change)(*value);
        }
    }
}

struct EachWith<'a, F> {
    values: &'a mut [f64],
    partners: &'a [f64],
    change: F,
}

impl<F: Fn(f64, f64) -> f64> Work for EachWith<'_, F> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        for (value, partner) in self.values.iter_mut().zip(self.partners) {
            *value = (self.change)(*value, *partner);
        }
    }
}

/// Something to do in a loop, or several.
pub(crate) trait Work {
    /// The type of the result.
    type Output;

    /// Does it. Must be inlined, and all that it calls, to be built for wider vectors.
    fn work(self) -> Self::Output;
}

/// Does the work.
pub(crate) fn with_vectors<W: Work>(work: W) -> W::Output {
    #[cfg(feature = "simd")]
    return pulp::Arch::new().dispatch(Wide(work));
    #[cfg(not(feature = "simd"))]
    work.work()
}

#[cfg(feature = "simd")]
struct Wide<W>(W);

#[cfg(feature = "simd")]
impl<W: Work> pulp::WithSimd for Wide<W> {
    type Output = W::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> W::Output {
        self.0.work()
    }
}

//! The widest vectors that the processor has, for loops that are worth it.
//!
//! A program is built for the least processor of its kind, whose vectors hold two numbers. With the feature `simd` the
//! loops here are built for wider ones as well, and the processor is asked which it has. The operations are the same,
//! number by number, and so are the bits: nothing is fused or reordered.

/// Something to do in a loop, or several.
pub(crate) trait Work {
    /// What comes of it.
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

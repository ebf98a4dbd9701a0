//! Robots side by side: the same loops on one thread, and with the feature `rayon` on as many as there are.
//!
//! The events of a robot in such a loop depend on nothing that another's turn in it changes, so the bits are the same
//! for any number and order of threads.

/// Does the work for each robot and its place in a list of results.
pub(crate) fn each<T: Send, R: Send>(
    is_parallel: bool,
    items: &mut [T],
    results: &mut [R],
    visit: impl Fn(usize, &mut T, &mut R) + Sync + Send,
) {
    #[cfg(feature = "rayon")]
    if is_parallel && items.len() >= 2 * FEWEST {
        use rayon::prelude::*;
        let items = items.par_iter_mut().with_min_len(FEWEST);
        return items.zip(results).enumerate().for_each(|(i, (item, result))| visit(i, item, result));
    }
    let _ = is_parallel;
    items.iter_mut().zip(results).enumerate().for_each(|(i, (item, result))| visit(i, item, result));
}

/// A thread takes at least so many robots at a time: fewer are not worth the call.
#[cfg(feature = "rayon")]
const FEWEST: usize = 16;

//! The segments that a few rays may meet: several are examined at once, since most are far from all rays.

use super::about::Cone;
use crate::circle::Circle;
use crate::pose::Vector;
use crate::segment::Segment;
use crate::vectors::Work;

/// The search for segments that may be met by rays that start and end in a disc.
pub(super) struct Look<'a> {
    pub(super) cone: &'a Cone,
    pub(super) around: Circle,
    /// More than rounding can make of coordinates in the disc.
    pub(super) slack: f64,
    pub(super) stray: f64,
    pub(super) segments: &'a [Segment],
    /// A mask for each segment, in the form of vectors: all bits if it may be met, none otherwise.
    pub(super) may_meet: &'a mut [u64],
}

impl Work for Look<'_> {
    type Output = ();

    #[inline(always)]
    fn work(self) {
        match *self.cone {
            Cone::Narrow(sides) => {
                let stray = self.stray;
                self.mark(|a, b| sides.have_beside(a, b, stray));
            }
            Cone::Wide => self.mark(|_, _| false),
        }
    }
}

impl Look<'_> {
    #[inline(always)]
    fn mark(self, is_beside: impl Fn(&Vector, &Vector) -> bool) {
        let Circle { center, radius } = self.around;
        let most = radius + self.slack;
        for (may_meet, segment) in self.may_meet.iter_mut().zip(self.segments) {
            let a = Vector::new(segment.start.x - center.x, segment.start.y - center.y);
            let b = Vector::new(segment.end.x - center.x, segment.end.y - center.y);
            let is_far = ((a.x > most) & (b.x > most))
                | ((a.x < -most) & (b.x < -most))
                | ((a.y > most) & (b.y > most))
                | ((a.y < -most) & (b.y < -most));
            *may_meet = if is_far | is_beside(&a, &b) { 0 } else { u64::MAX };
        }
    }
}

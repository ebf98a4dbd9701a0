//! Tracks for events that overlap. Slices of one track must nest, so overlapping events go on further tracks of their lane.

use baudbot_sim::SimTime;
use baudbot_sim::timeline::Event;

/// A lane's events on their way to its tracks.
///
/// Events come in about the order of their ends. A few of them wait here, so that they leave in the order of their
/// beginnings, as then the fewest tracks are needed. Whichever order they leave in, no two slices of a track overlap.
#[derive(Debug, Default)]
pub(crate) struct Tracks {
    /// The waiting events by their beginnings, the latest first.
    waiting: Vec<Event>,
    /// The end of each track's last slice.
    ends: Vec<SimTime>,
}

/// The place of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// A slice of this track.
    Slice(usize),
    /// A mark on the first track.
    Instant,
}

impl Tracks {
    /// Takes an event; gives one back whose turn it is, if too many wait.
    pub(crate) fn push(&mut self, event: Event) -> Option<(Event, Place)> {
        let key = |event: &Event| (event.start, event.end);
        let place = self.waiting.partition_point(|other| key(other) > key(&event));
        self.waiting.insert(place, event);
        if self.waiting.len() > WAITING { self.pop() } else { None }
    }

    /// The next one of those that wait.
    pub(crate) fn pop(&mut self) -> Option<(Event, Place)> {
        let event = self.waiting.pop()?;
        Some((event, self.place(&event)))
    }

    fn place(&mut self, event: &Event) -> Place {
        if event.end <= event.start {
            return Place::Instant;
        }
        let free = self.ends.iter().position(|end| *end <= event.start);
        let Some(track) = free.or_else(|| self.another()) else { return Place::Instant };
        self.ends[track] = event.end;
        Place::Slice(track)
    }

    fn another(&mut self) -> Option<usize> {
        let track = self.ends.len();
        (track < MOST).then(|| self.ends.push(SimTime::ZERO))?;
        Some(track)
    }
}

/// The most events that wait.
const WAITING: usize = 32;
/// The most overlapping events; of any more only a mark is left, so that a trace cannot have any number of tracks.
pub(crate) const MOST: usize = 32;

#[cfg(test)]
mod tests {
    use baudbot_sim::timeline::What;

    use super::*;

    fn placed(spans: impl IntoIterator<Item = (u64, u64)>) -> Vec<(u64, u64, Place)> {
        let mut tracks = Tracks::default();
        let event = |(start, end)| Event {
            start: SimTime::from_ns(start),
            end: SimTime::from_ns(end),
            what: What::Block,
        };
        let mut left: Vec<_> = spans.into_iter().filter_map(|span| tracks.push(event(span))).collect();
        left.extend(std::iter::from_fn(|| tracks.pop()));
        left.into_iter().map(|(event, place)| (event.start.as_ns(), event.end.as_ns(), place)).collect()
    }

    #[test]
    fn what_follows_stays_on_its_track_and_what_overlaps_goes_on_another() {
        let placed = placed([(0, 10), (10, 20), (15, 25), (25, 30), (22, 23)]);
        let expected = [
            (0, 10, Place::Slice(0)),
            (10, 20, Place::Slice(0)),
            (15, 25, Place::Slice(1)),
            (22, 23, Place::Slice(0)),
            (25, 30, Place::Slice(0)),
        ];
        assert_eq!(placed, expected);
    }

    #[test]
    fn what_takes_no_time_or_negative_time_is_a_mark() {
        assert_eq!(placed([(5, 5), (9, 3)]), [(5, 5, Place::Instant), (9, 3, Place::Instant)]);
    }

    #[test]
    fn the_number_of_tracks_is_bounded() {
        let placed = placed((0..1000).map(|i| (i, 1_000_000)));
        let slices = placed.iter().filter(|(.., place)| *place != Place::Instant).count();
        assert_eq!((placed.len(), slices), (1000, MOST));
    }

    #[test]
    fn slices_of_a_track_never_overlap_in_whichever_order_they_come() {
        let mut seed = 1_u64;
        let mut next = |below: u64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 33) % below
        };
        let spans: Vec<_> = (0..5000)
            .map(|i| {
                let start = i * 5 + next(2000);
                (start, start + next(60))
            })
            .collect();
        let mut ends = [0; MOST];
        for (start, end, place) in placed(spans) {
            if let Place::Slice(track) = place {
                assert!(
                    start >= ends[track],
                    "{start} to {end} on track {track}, taken until {}",
                    ends[track]
                );
                ends[track] = end;
            }
        }
    }
}

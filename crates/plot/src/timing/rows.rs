//! The rows of a lane: bars that overlap are in different rows.

use super::diagram::Bar;

/// The bars of each row, in their order. There is at least one row, and at most a few: bars that find no place are in the
/// last one, over others.
pub(super) fn rows(bars: &[Bar]) -> Vec<Vec<&Bar>> {
    let mut sorted: Vec<_> = bars.iter().collect();
    sorted.sort_by_key(|bar| (bar.start_ns, bar.end_ns));
    let mut rows: Vec<Vec<&Bar>> = vec![Vec::new()];
    for bar in sorted {
        let free = rows.iter().position(|row| row.last().is_none_or(|last| follows(bar, last)));
        match free {
            Some(row) => rows[row].push(bar),
            None if rows.len() < MOST => rows.push(vec![bar]),
            None => rows[MOST - 1].push(bar),
        }
    }
    rows
}

/// Whether there is room for it after another. Two marks of one instant would hide each other.
fn follows(bar: &Bar, last: &Bar) -> bool {
    let are_marks = bar.is_mark() && last.is_mark();
    last.end_ns <= bar.start_ns && !(are_marks && last.start_ns == bar.start_ns)
}

/// The most rows.
const MOST: usize = 6;

#[cfg(test)]
mod tests {
    use super::super::class::Class;
    use super::*;

    fn spans(bars: &[(u64, u64)]) -> Vec<Vec<(u64, u64)>> {
        let bars: Vec<_> = bars
            .iter()
            .map(|&(start_ns, end_ns)| Bar {
                start_ns,
                end_ns,
                label: String::new(),
                title: String::new(),
                class: Class::Up,
                is_aside: false,
            })
            .collect();
        rows(&bars).iter().map(|row| row.iter().map(|bar| (bar.start_ns, bar.end_ns)).collect()).collect()
    }

    #[test]
    fn what_follows_is_in_one_row_and_what_overlaps_is_not() {
        assert_eq!(spans(&[(20, 30), (0, 10), (10, 20)]), [[(0, 10), (10, 20), (20, 30)]]);
        assert_eq!(spans(&[(0, 10), (5, 15), (10, 12)]), [vec![(0, 10), (10, 12)], vec![(5, 15)]]);
    }

    #[test]
    fn marks_of_one_instant_do_not_hide_each_other() {
        assert_eq!(spans(&[(5, 5), (5, 5), (5, 8)]), [vec![(5, 5), (5, 8)], vec![(5, 5)]]);
    }

    #[test]
    fn rows_are_few_however_much_overlaps() {
        let all: Vec<_> = (0..50).map(|i| (i, 1000)).collect();
        let rows = spans(&all);
        assert_eq!((rows.len(), rows.iter().map(Vec::len).sum::<usize>()), (MOST, 50));
        assert_eq!(spans(&[]), [[]]);
    }
}

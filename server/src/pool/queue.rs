//! The run queue of a pool: which task a thread takes next. No threads and no clock are in it, so that a test can play both.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{Task, Then};

/// A task that has waited for so long since its last slice, or since it was woken, goes before those that follow the clock, once in
/// [`RELIEF_EVERY`].
const STARVED: Duration = Duration::from_millis(100);

/// The interval of relief. A slice takes half a millisecond, so it takes little from those that follow the clock.
const RELIEF_EVERY: Duration = Duration::from_millis(20);

/// The number of a task in its pool.
pub(crate) type Number = u64;

/// All tasks of a pool, and those of them that have something to do.
pub(super) struct Queue {
    tasks: BTreeMap<Number, Entry>,
    last_number: Number,
    /// Tasks that have to run at an instant, most urgent first.
    alarms: BTreeSet<(Instant, Number)>,
    /// Tasks that something has happened to, each with when.
    woken: VecDeque<(Instant, Number)>,
    /// Tasks that have more to do after a slice, each with the end of that slice.
    spent: VecDeque<(Instant, Number)>,
    /// Tasks whose next step takes long.
    long: VecDeque<Number>,
    relieved: Option<Instant>,
}

struct Entry {
    task: Arc<dyn Task>,
    alarm: Option<Instant>,
    /// Whether it is in one of the queues without an instant.
    is_ready: bool,
}

/// A task to be run.
pub(super) type Picked = (Number, Arc<dyn Task>);

impl Queue {
    pub(super) fn new() -> Self {
        Self {
            tasks: BTreeMap::new(),
            last_number: 0,
            alarms: BTreeSet::new(),
            woken: VecDeque::new(),
            spent: VecDeque::new(),
            long: VecDeque::new(),
            relieved: None,
        }
    }

    /// The number of tasks that are not over.
    pub(super) fn len(&self) -> usize {
        self.tasks.len()
    }

    /// Adds a task, which has something to do.
    pub(super) fn add(&mut self, now: Instant, make: impl FnOnce(Number) -> Arc<dyn Task>) {
        self.last_number += 1;
        let entry = Entry { task: make(self.last_number), alarm: None, is_ready: true };
        self.tasks.insert(self.last_number, entry);
        self.woken.push_back((now, self.last_number));
    }

    /// A task has something to do; if its pace follows the clock, by an instant.
    pub(super) fn wake(&mut self, number: Number, by: Option<Instant>, now: Instant) {
        match by {
            Some(by) => self.set_alarm(number, by),
            None => {
                if self.make_ready(number) {
                    self.woken.push_back((now, number));
                }
            }
        }
    }

    /// Takes the task that comes first: those that follow the clock by their deadlines, then what has been woken, then what
    /// has had a slice already.
    pub(super) fn pick(&mut self, now: Instant) -> Option<Picked> {
        if let Some(starved) = self.pick_starved(now) {
            self.relieved = Some(now);
            return Some(starved);
        }
        if let Some(&(at, number)) = self.alarms.first()
            && at <= now
        {
            return self.take(number);
        }
        self.pick_woken().or_else(|| self.pick_spent())
    }

    /// Takes a task whose next step takes long.
    pub(super) fn pick_long(&mut self) -> Option<Picked> {
        while let Some(number) = self.long.pop_front() {
            if let Some(picked) = self.take_ready(number) {
                return Some(picked);
            }
        }
        None
    }

    /// A task that was taken has run until `now`, and this is what is to be done about it. Gives one that is to run on a
    /// thread of its own.
    pub(super) fn settle(&mut self, number: Number, then: Then, now: Instant) -> Option<Picked> {
        match then {
            Then::Run(Some(by)) | Then::Wait(Some(by)) => self.set_alarm(number, by),
            Then::Run(None) => {
                if self.make_ready(number) {
                    self.spent.push_back((now, number));
                }
            }
            Then::RunLong => {
                if self.make_ready(number) {
                    self.long.push_back(number);
                }
            }
            Then::RunApart => return self.take(number),
            Then::Wait(None) => {}
            Then::Over => {
                if let Some(alarm) = self.tasks.remove(&number).and_then(|entry| entry.alarm) {
                    self.alarms.remove(&(alarm, number));
                }
            }
        }
        None
    }

    /// Whether there is a task to be taken that waits for no instant.
    pub(super) fn is_any_ready(&self) -> bool {
        !self.woken.is_empty() || !self.spent.is_empty()
    }

    pub(super) fn is_any_long(&self) -> bool {
        !self.long.is_empty()
    }

    /// The instant at which a task is to run next that waits for an instant.
    pub(super) fn next_alarm(&self) -> Option<Instant> {
        self.alarms.first().map(|&(at, _)| at)
    }

    /// Takes one that has waited too long, if it is time for that.
    fn pick_starved(&mut self, now: Instant) -> Option<Picked> {
        let has_waited = |since: Instant, long| now.saturating_duration_since(since) >= long;
        if self.relieved.is_some_and(|relieved| !has_waited(relieved, RELIEF_EVERY)) {
            return None;
        }
        let since = |queue: &VecDeque<(Instant, Number)>| queue.front().map(|&(since, _)| since);
        let (woken, spent) = (since(&self.woken), since(&self.spent));
        let longest = woken.into_iter().chain(spent).min().filter(|&since| has_waited(since, STARVED))?;
        if woken == Some(longest) { self.pick_woken() } else { self.pick_spent() }
    }

    fn pick_woken(&mut self) -> Option<Picked> {
        while let Some((_, number)) = self.woken.pop_front() {
            if let Some(picked) = self.take_ready(number) {
                return Some(picked);
            }
        }
        None
    }

    fn pick_spent(&mut self) -> Option<Picked> {
        while let Some((_, number)) = self.spent.pop_front() {
            if let Some(picked) = self.take_ready(number) {
                return Some(picked);
            }
        }
        None
    }

    /// Notes that a task is in a queue without an instant; `false` if it was, or is over.
    fn make_ready(&mut self, number: Number) -> bool {
        self.tasks.get_mut(&number).is_some_and(|entry| !std::mem::replace(&mut entry.is_ready, true))
    }

    /// Sets a task's alarm, unless it has an earlier one.
    fn set_alarm(&mut self, number: Number, at: Instant) {
        let Some(entry) = self.tasks.get_mut(&number) else { return };
        if entry.alarm.is_some_and(|alarm| alarm <= at) {
            return;
        }
        if let Some(later) = entry.alarm.replace(at) {
            self.alarms.remove(&(later, number));
        }
        self.alarms.insert((at, number));
    }

    /// Takes a task out of its queue. One that is over meanwhile is not there any more.
    fn take_ready(&mut self, number: Number) -> Option<Picked> {
        self.tasks.get_mut(&number)?.is_ready = false;
        self.take(number)
    }

    /// Takes a task, which states anew when it has to run.
    fn take(&mut self, number: Number) -> Option<Picked> {
        let entry = self.tasks.get_mut(&number)?;
        if let Some(alarm) = entry.alarm.take() {
            self.alarms.remove(&(alarm, number));
        }
        Some((number, Arc::clone(&entry.task)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pool::Place;

    struct Nothing;

    impl Task for Nothing {
        fn run(&self, _: Place) -> Then {
            Then::Over
        }
    }

    /// A queue of so many tasks that nothing has happened to.
    fn queue(tasks: u64, now: Instant) -> Queue {
        let mut queue = Queue::new();
        for _ in 0..tasks {
            queue.add(now, |_| Arc::new(Nothing));
        }
        while let Some((number, _)) = queue.pick(now) {
            queue.settle(number, Then::Wait(None), now);
        }
        queue
    }

    fn picked(queue: &mut Queue, now: Instant) -> Option<Number> {
        queue.pick(now).map(|(number, _)| number)
    }

    #[test]
    fn tasks_with_an_instant_come_first_and_the_earliest_of_them_before_the_others() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut queue = queue(5, start);
        queue.settle(1, Then::Run(None), start);
        queue.wake(2, None, start);
        queue.settle(3, Then::Wait(Some(at(7))), start);
        queue.settle(4, Then::Wait(Some(at(5))), start);
        queue.settle(5, Then::Wait(Some(at(20))), start);
        let order: Vec<_> = std::iter::from_fn(|| picked(&mut queue, at(10))).collect();
        assert_eq!(order, [4, 3, 2, 1], "the fifth is not due yet");
        assert_eq!(queue.next_alarm(), Some(at(20)));
    }

    #[test]
    fn tasks_that_always_have_more_to_do_take_turns() {
        let start = Instant::now();
        let mut queue = queue(3, start);
        (1..=3).for_each(|number| drop(queue.settle(number, Then::Run(None), start)));
        let mut order = Vec::new();
        for _ in 0..6 {
            let number = picked(&mut queue, start).unwrap();
            queue.settle(number, Then::Run(None), start);
            order.push(number);
        }
        assert_eq!(order, [1, 2, 3, 1, 2, 3]);
    }

    #[test]
    fn tasks_that_follow_the_clock_leave_a_little_to_the_others_however_much_they_have_to_do() {
        let start = Instant::now();
        let mut queue = queue(2, start);
        queue.settle(1, Then::Run(None), start);
        queue.settle(2, Then::Run(Some(start)), start);
        let mut others = 0;
        for ms in 0..1000 {
            let now = start + Duration::from_millis(ms);
            let number = picked(&mut queue, now).unwrap();
            let then = if number == 2 { Then::Run(Some(now)) } else { Then::Run(None) };
            queue.settle(number, then, now);
            others += u32::from(number == 1);
        }
        assert_eq!(others, 9, "one slice each time it has waited for 100 ms");
    }

    /// Such as a world that has just been made.
    #[test]
    fn a_task_that_is_new_begins_however_much_those_that_follow_the_clock_have_to_do() {
        let start = Instant::now();
        let mut queue = queue(1, start);
        queue.settle(1, Then::Run(Some(start)), start);
        (0..3).for_each(|_| queue.add(start, |_| Arc::new(Nothing)));
        let mut begun = Vec::new();
        for ms in 0..200 {
            let now = start + Duration::from_millis(ms);
            let number = picked(&mut queue, now).unwrap();
            let then = if number == 1 { Then::Run(Some(now)) } else { Then::Wait(None) };
            queue.settle(number, then, now);
            begun.extend((number != 1).then_some((ms, number)));
        }
        assert_eq!(begun, [(100, 2), (120, 3), (140, 4)], "one each 20 ms");
    }

    #[test]
    fn a_task_that_is_over_is_not_taken_again_and_hides_no_other() {
        let start = Instant::now();
        let mut queue = queue(3, start);
        queue.wake(1, None, start);
        queue.wake(2, None, start);
        queue.wake(3, Some(start), start);
        queue.settle(1, Then::Over, start);
        queue.settle(3, Then::Over, start);
        assert_eq!((picked(&mut queue, start), picked(&mut queue, start)), (Some(2), None));
        assert_eq!((queue.len(), queue.next_alarm()), (1, None));
    }

    #[test]
    fn a_task_that_is_woken_twice_runs_once_and_its_earliest_alarm_counts() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut queue = queue(1, start);
        queue.wake(1, None, start);
        queue.wake(1, None, start);
        queue.wake(1, Some(at(9)), start);
        queue.wake(1, Some(at(4)), start);
        queue.wake(1, Some(at(6)), start);
        assert_eq!(queue.next_alarm(), Some(at(4)));
        assert_eq!((picked(&mut queue, start), picked(&mut queue, at(10))), (Some(1), None));
    }

    #[test]
    fn a_long_step_is_for_none_that_takes_short_ones() {
        let start = Instant::now();
        let mut queue = queue(2, start);
        queue.settle(1, Then::RunLong, start);
        queue.settle(2, Then::RunLong, start);
        assert!(queue.is_any_long() && !queue.is_any_ready() && queue.pick(start).is_none());
        let order = [queue.pick_long(), queue.pick_long(), queue.pick_long()];
        assert_eq!(order.map(|picked| picked.map(|(number, _)| number)), [Some(1), Some(2), None]);
    }
}

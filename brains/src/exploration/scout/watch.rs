//! Whether an explorer gets on: a goal that is not reached in some times its way is given up, and who has not got on for most of a minute
//! ends.
//!
//! It gets on when it knows more of the floor, or when it comes nearer to a goal than it ever was. So one that goes to and fro between
//! two goals does not get on, however much it drives. Time counts as much as the robot may drive of what it wants.
//!
//! A robot that drives from one goal to the next and sees nothing new gets on by this rule, and need not be wrong: so it goes on, and
//! [states](Watch::without_news_s) for how long that has been so.

use std::collections::BTreeMap;

use baudbot_geometry::math;

use crate::exploration::Goal;

/// The result of watching.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The robot makes progress, or there is time yet.
    GoesOn,
    /// The robot does not get to its goal.
    Abandon,
    /// The robot makes no progress at all.
    Ends,
}

/// The attempts so far, and their results.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    /// Goals in the same square of this side are the same, in metres.
    side_m: f64,
    /// The speed if nothing is in its way, in metres a second.
    speed_m_s: f64,
    tried: BTreeMap<(i64, i64), Tried>,
    /// The area of the floor that was known when it last got on, in square metres.
    known_m2: f64,
    /// The time for which it has made no progress, in seconds.
    quiet_s: f64,
    /// The time for which it has known no more of the floor, in seconds.
    without_news_s: f64,
}

#[derive(Clone, Copy, Debug)]
struct Tried {
    /// The way that was left when it was last nearer than ever, in metres.
    least_m: f64,
    /// The time that it is allowed, in seconds ...
    allowed_s: f64,
    /// ... and has spent, ...
    spent_s: f64,
    /// ... since it was last nearer than ever.
    quiet_s: f64,
}

impl Watch {
    /// A `Watch` for a robot with this radius, in metres, that drives at this speed, in metres a second, where it has
    /// room.
    pub(super) fn new(radius_m: f64, speed_m_s: f64) -> Self {
        let speed_m_s = SLOW * speed_m_s;
        Self {
            side_m: 2.0 * radius_m,
            speed_m_s,
            tried: BTreeMap::new(),
            known_m2: 0.0,
            quiet_s: 0.0,
            without_news_s: 0.0,
        }
    }

    /// Notes the time with this goal, and the known part of the floor, in square metres.
    pub(super) fn look(&mut self, passed_s: f64, goal: Option<Goal>, known_m2: f64) -> Verdict {
        self.quiet_s += passed_s;
        self.without_news_s += passed_s;
        if known_m2 > self.known_m2 + self.side_m * self.side_m {
            self.known_m2 = known_m2;
            self.without_news_s = 0.0;
            self.rest();
        }
        let verdict = goal.map_or(Verdict::GoesOn, |goal| self.pursue(passed_s, goal));
        if self.quiet_s > PATIENCE_S { Verdict::Ends } else { verdict }
    }

    /// The time for which it has known no more of the floor, in whole steps of 15 seconds, if that is long.
    pub(super) fn without_news_s(&self) -> Option<u32> {
        let steps = math::floor(self.without_news_s / NEWS_STEP_S);
        (steps >= NEWS_STEPS).then_some((steps * NEWS_STEP_S) as u32)
    }

    /// Earlier standstill does not count.
    pub(super) fn rest(&mut self) {
        self.quiet_s = 0.0;
    }

    fn pursue(&mut self, passed_s: f64, Goal { place, left_m }: Goal) -> Verdict {
        let square = |m: f64| math::floor(m / self.side_m) as i64;
        let allowed_s = TIMES * left_m / self.speed_m_s + GRACE_S;
        let new = Tried { least_m: f64::INFINITY, allowed_s, spent_s: 0.0, quiet_s: 0.0 };
        let tried = self.tried.entry((square(place.x), square(place.y))).or_insert(new);
        tried.spent_s += passed_s;
        tried.quiet_s += passed_s;
        if left_m < tried.least_m - 0.125 * self.side_m {
            tried.least_m = left_m;
            tried.quiet_s = 0.0;
            self.quiet_s = 0.0;
        }
        if tried.quiet_s > QUIET_S || tried.spent_s > tried.allowed_s {
            // Another goal may be in the same square.
            *tried = Tried { spent_s: 0.0, quiet_s: 0.0, ..*tried };
            return Verdict::Abandon;
        }
        Verdict::GoesOn
    }
}

/// A goal must be reached in so many times its way ...
const TIMES: f64 = 3.0;
/// ... at this part of the speed, ...
const SLOW: f64 = 0.5;
/// ... and so many seconds, for turns and looks.
const GRACE_S: f64 = 20.0;
/// A goal to which the robot has not come nearer for so many seconds is given up.
const QUIET_S: f64 = 15.0;
/// The time without progress after which a robot ends, in seconds.
const PATIENCE_S: f64 = 45.0;
/// The time without news is stated in steps of so many seconds, ...
const NEWS_STEP_S: f64 = 15.0;
/// ... from so many of them on.
const NEWS_STEPS: f64 = 2.0;

#[cfg(test)]
mod tests {
    use baudbot_geometry::Point;

    use super::*;

    /// The instants at which a robot with these goals and this way left at an instant, in seconds, first abandons a
    /// goal, and at which it ends.
    fn ends(goal: impl Fn(f64) -> (f64, f64)) -> (Option<f64>, Option<f64>) {
        let mut watch = Watch::new(0.2, 0.3);
        let (mut abandoned_s, mut ended_s) = (None, None);
        for i in 0..400 {
            let at_s = 0.5 * f64::from(i);
            let (x, left_m) = goal(at_s);
            match watch.look(0.5, Some(Goal { place: Point::new(x, 0.1), left_m }), 0.0) {
                Verdict::GoesOn => {}
                Verdict::Abandon => abandoned_s = abandoned_s.or(Some(at_s)),
                Verdict::Ends => ended_s = ended_s.or(Some(at_s)),
            }
        }
        (abandoned_s, ended_s)
    }

    #[test]
    fn who_comes_nearer_gets_on_and_who_goes_to_and_fro_does_not() {
        assert_eq!(ends(|at_s| (30.1, 60.0 - 0.3 * at_s)), (None, None), "a long way");
        let (abandoned_s, ended_s) = ends(|_| (5.1, 2.0));
        assert!((14.0..17.0).contains(&abandoned_s.unwrap()) && (44.0..47.0).contains(&ended_s.unwrap()));
        // Two metres towards one goal, two towards the other.
        let (abandoned_s, ended_s) = ends(|at_s| {
            let (turn, part) = ((at_s / 10.0).floor(), (at_s % 10.0) / 10.0);
            (if turn % 2.0 == 0.0 { 1.1 } else { 9.1 }, 4.0 - 2.0 * part)
        });
        assert!(abandoned_s.unwrap() < 60.0 && ended_s.unwrap() < 70.0, "{abandoned_s:?}, {ended_s:?}");
    }

    #[test]
    fn who_comes_to_know_more_gets_on() {
        let mut watch = Watch::new(0.2, 0.3);
        for i in 0..400 {
            assert_eq!(watch.look(0.5, None, 0.01 * f64::from(i)), Verdict::GoesOn, "{i}");
            assert_eq!(watch.without_news_s(), None, "{i}");
        }
    }

    #[test]
    fn who_goes_from_goal_to_goal_without_news_says_so() {
        let mut watch = Watch::new(0.2, 0.3);
        let mut said = Vec::new();
        for i in 0..180 {
            let at_s = 0.5 * f64::from(i);
            // Each goal lies in another square, and comes nearer.
            let goal = Goal { place: Point::new(at_s.floor(), 0.1), left_m: 4.0 - 2.0 * at_s.fract() };
            assert_eq!(watch.look(0.5, Some(goal), 0.0), Verdict::GoesOn, "{at_s}");
            if said.last() != Some(&watch.without_news_s()) {
                said.push(watch.without_news_s());
            }
        }
        assert_eq!(said, [None, Some(30), Some(45), Some(60), Some(75), Some(90)]);
    }
}

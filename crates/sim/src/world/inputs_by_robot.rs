//! The assignment of inputs to robots.

use alloc::vec::Vec;

/// The places of a tick's inputs, robot by robot. Its memory serves all ticks.
#[derive(Debug, Default)]
pub(super) struct InputsByRobot {
    /// The beginning of each robot's in `places`; one more at the end.
    starts: Vec<u32>,
    places: Vec<u32>,
}

impl InputsByRobot {
    /// Takes the inputs of so many robots, of each its robot; an index that no robot has is left out.
    pub(super) fn note(
        &mut self,
        inputs: impl DoubleEndedIterator<Item = usize> + ExactSizeIterator + Clone,
        robots: usize,
    ) {
        self.starts.clear();
        self.starts.resize(robots + 1, 0);
        let known = || inputs.clone().enumerate().filter(|(_, robot)| *robot < robots);
        known().for_each(|(_, robot)| self.starts[robot] += 1);
        let mut end = 0;
        for start in &mut self.starts {
            end += *start;
            *start = end;
        }
        self.places.clear();
        self.places.resize(end as usize, 0);
        // From behind, so that those of one robot keep their order.
        for (place, robot) in known().rev() {
            let start = &mut self.starts[robot];
            *start -= 1;
            self.places[*start as usize] = place as u32;
        }
    }

    /// The places of a robot's inputs, in their order.
    pub(super) fn of(&self, robot: usize) -> impl Iterator<Item = usize> {
        let places = self.starts[robot] as usize..self.starts[robot + 1] as usize;
        self.places[places].iter().map(|&place| place as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_robot_has_its_own_in_their_order() {
        let inputs = [2, 0, 9, 2, 0, 2];
        let mut inputs_by_robot = InputsByRobot::default();
        for _ in 0..2 {
            inputs_by_robot.note(inputs.into_iter(), 3);
            let found: Vec<Vec<_>> = (0..3).map(|robot| inputs_by_robot.of(robot).collect()).collect();
            assert_eq!(found, [alloc::vec![1, 4], alloc::vec![], alloc::vec![0, 3, 5]]);
        }
        inputs_by_robot.note([].into_iter(), 1);
        assert_eq!(inputs_by_robot.of(0).count(), 0);
    }
}

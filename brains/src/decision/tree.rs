//! A behaviour tree: conditions and behaviours under nodes that try one after the other. The tree itself is the crate
//! `bonsai-bt`'s.
//!
//! It is *reactive*: each step begins at the root again, so that a condition to the left of what is active can take the motors
//! from it at any time. A behaviour is always under way; the first that is reached has the motors.

use bonsai_bt::{BT, Behavior, Event, Failure, Running, Success, UpdateArgs};

use super::condition::Condition;

/// A part of a tree.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// Tries its parts from the left until one succeeds or is under way. Fails if all fail.
    Select(Vec<Self>),
    /// Does its parts from the left until one fails or is under way. Succeeds if all do.
    Sequence(Vec<Self>),
    /// Fails if its part succeeds, and the other way round.
    Invert(Box<Self>),
    /// Succeeds if it holds, and fails if not.
    Condition(Condition),
    /// A motor behaviour, by its place.
    Behavior(usize),
}

/// A tree that decides.
#[derive(Clone, Debug)]
pub struct Tree {
    tree: BT<Leaf, ()>,
    /// The tree as it was described.
    pub(crate) root: Node,
    pub(crate) active: usize,
}

#[derive(Clone, Debug, PartialEq)]
enum Leaf {
    Condition(Condition),
    Behavior(usize),
}

impl Tree {
    /// `start` is active until the tree reaches a behaviour.
    pub fn new(root: &Node, start: usize) -> Self {
        Self { tree: BT::new(root.behavior(), ()), root: root.clone(), active: start }
    }

    /// Goes through the tree. Returns which behaviour is active then: if none was reached, that of before.
    pub fn step(&mut self, state: &[f64]) -> usize {
        let event: Event = UpdateArgs::zero_dt().into();
        let mut active = self.active;
        let ended = self.tree.tick(
            &event,
            &mut |args: bonsai_bt::ActionArgs<'_, Event, Leaf>, ()| match args.action {
                Leaf::Condition(condition) if condition.holds(state) => (Success, args.dt),
                Leaf::Condition(_) => (Failure, args.dt),
                Leaf::Behavior(behavior) => {
                    active = *behavior;
                    (Running, 0.0)
                }
            },
        );
        if ended.is_none_or(|(status, _)| status != Running) {
            self.tree.reset_bt();
        }
        self.active = active;
        active
    }
}

impl Node {
    fn behavior(&self) -> Behavior<Leaf> {
        let all = |nodes: &[Self]| nodes.iter().map(Self::behavior).collect();
        match self {
            Self::Select(nodes) => Behavior::Select(all(nodes)).memory(false),
            Self::Sequence(nodes) => Behavior::Sequence(all(nodes)).memory(false),
            Self::Invert(node) => Behavior::Invert(Box::new(node.behavior())),
            Self::Condition(condition) => Behavior::Action(Leaf::Condition(condition.clone())),
            Self::Behavior(behavior) => Behavior::Action(Leaf::Behavior(*behavior)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn when(text: &str) -> Node {
        Node::Condition(Condition::parse(text, &["near", "empty"]).unwrap())
    }

    #[test]
    fn what_is_to_the_left_takes_the_motors_at_any_time() {
        let root = Node::Select(vec![
            Node::Sequence(vec![when("near > 1"), Node::Behavior(2)]),
            Node::Sequence(vec![Node::Invert(Box::new(when("empty <= 1"))), Node::Behavior(1)]),
            Node::Behavior(0),
        ]);
        let mut tree = Tree::new(&root, 0);
        let states = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0], [0.0, 2.0], [2.0, 0.0]];
        let course: Vec<_> = states.iter().map(|state| tree.step(state)).collect();
        assert_eq!(course, [0, 2, 2, 1, 0, 1, 2]);
    }

    #[test]
    fn where_nothing_is_reached_all_stays_as_it_was() {
        let root = Node::Sequence(vec![when("near > 1"), Node::Behavior(1)]);
        let mut tree = Tree::new(&root, 0);
        let course: Vec<_> = [0.0, 0.0, 2.0, 0.0, 2.0].iter().map(|&near| tree.step(&[near, 0.0])).collect();
        assert_eq!(course, [0, 0, 1, 1, 1]);
    }
}

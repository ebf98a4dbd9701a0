//! What a [`Rule::Whenever`](crate::Rule::Whenever) remembers: triggers whose time is not over, and reactions since.

use std::collections::VecDeque;

use crate::margin::Margin;

/// A margin at an instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    pub(crate) margin: Margin,
    pub(crate) at_ns: u64,
}

impl Moment {
    /// The one of the smaller margin, the first one of equal ones.
    pub(crate) fn worse(self, later: Self) -> Self {
        if later.margin < self.margin { later } else { self }
    }

    /// The one of the greater margin, the first one of equal ones.
    pub(crate) fn better(self, later: Self) -> Self {
        if later.margin > self.margin { later } else { self }
    }
}

/// The greatest reaction since each of the triggers that are open, by a queue in which reactions become smaller: one that is
/// followed by a greater one is not the greatest of any window any more.
#[derive(Clone, Debug, Default)]
pub(crate) struct Window {
    /// Margins by which triggers do not hold.
    triggers: VecDeque<Moment>,
    reactions: VecDeque<Moment>,
}

impl Window {
    /// Takes a sample in: by how much the trigger does not hold, and by how much the reaction does.
    pub(crate) fn add(&mut self, no_trigger: Moment, reaction: Moment) {
        self.triggers.push_back(no_trigger);
        while self.reactions.pop_back_if(|earlier| earlier.margin <= reaction.margin).is_some() {}
        self.reactions.push_back(reaction);
    }

    /// Takes out a trigger whose time was over before an instant, with the margin of its implication.
    pub(crate) fn pop_closed(&mut self, now_ns: u64, within_ns: u64) -> Option<Moment> {
        let trigger = self.triggers.pop_front_if(|trigger| now_ns - trigger.at_ns > within_ns)?;
        while self.reactions.pop_front_if(|reaction| reaction.at_ns < trigger.at_ns).is_some() {}
        Some(implication(trigger, self.reactions.front()))
    }

    /// The open triggers from the first to the last, with the margins of their implications if nothing follows.
    pub(crate) fn open(&self) -> impl Iterator<Item = Moment> {
        let mut reactions = self.reactions.iter().peekable();
        self.triggers.iter().map(move |trigger| {
            while reactions.next_if(|reaction| reaction.at_ns < trigger.at_ns).is_some() {}
            implication(*trigger, reactions.peek().copied())
        })
    }
}

/// The sample of a trigger is itself in its window, so that there is a reaction.
fn implication(no_trigger: Moment, reaction: Option<&Moment>) -> Moment {
    let margin = reaction.map_or(no_trigger.margin, |reaction| no_trigger.margin.greatest(reaction.margin));
    Moment { margin, ..no_trigger }
}

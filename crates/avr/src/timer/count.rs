//! The counter: from corner to corner.

use super::mode::{Output, Slope, Top, Update};
use super::{CAPTURE, MATCH_A, MATCH_B, OVERFLOW, Source, Timer};

impl Timer {
    /// Brings the timer to this cycle, with the tick that happens in it.
    pub(crate) fn advance(&mut self, now: u64) {
        if self.noise_until <= now {
            let until = core::mem::replace(&mut self.noise_until, u64::MAX);
            self.count_to(until);
            self.take_capture();
        }
        self.count_to(now);
    }

    /// The next cycle at which something happens that is waited for.
    pub(crate) fn next_event(&self) -> u64 {
        let Source::Divided(division) = self.source() else { return self.noise_until };
        let wanted = (self.mask | self.triggers) & !self.flags;
        if self.off || (self.held && division > 1) || (wanted == 0 && self.watched == 0) {
            return self.noise_until;
        }
        let ticks = self.ticks_to_corner(self.watched | (wanted >> 1 & 3));
        let first = (self.at - self.zero) / division + 1;
        (self.zero + (first + u64::from(ticks) - 1) * division).min(self.noise_until)
    }

    fn count_to(&mut self, now: u64) {
        let from = core::mem::replace(&mut self.at, now);
        let Source::Divided(division) = self.source() else { return };
        if self.off || (self.held && division > 1) {
            return;
        }
        let ticks = if division == 1 {
            now - from
        } else {
            (now - self.zero) / division - (from - self.zero) / division
        };
        if ticks != 0 {
            self.count_ticks(ticks);
        }
    }

    fn count_ticks(&mut self, mut ticks: u64) {
        // After two periods all flags are set and all buffers are taken, and what toggles is as it was before.
        let twice = 2 * self.period();
        if ticks > 2 * twice && self.count <= self.top() {
            self.count_singly(twice);
            ticks = (ticks - twice) % (2 * self.period());
        }
        self.count_singly(ticks);
    }

    fn count_singly(&mut self, mut ticks: u64) {
        while ticks > 0 {
            let step = ticks.min(u64::from(self.ticks_to_corner(3)));
            let plain = u16::try_from(step - 1).unwrap_or(u16::MAX);
            if plain > 0 {
                self.blocked = false;
                self.count = if self.down { self.count - plain } else { self.count + plain };
            }
            self.tick();
            ticks -= step;
        }
    }

    /// Ticks until the counter has come round.
    fn period(&self) -> u64 {
        match self.mode().slope {
            Slope::Single | Slope::Fast => u64::from(self.top()) + 1,
            Slope::Dual => 2 * u64::from(self.top()).max(1),
        }
    }

    /// Ticks up to and with the next one that does more than count: 1 at least. Of the matches those in `channels` count.
    fn ticks_to_corner(&self, channels: u8) -> u32 {
        let count = u32::from(self.count);
        let mut nearest = if self.down {
            // To BOTTOM, and from there.
            count.max(1)
        } else {
            let dual = matches!(self.mode().slope, Slope::Dual);
            match self.top().checked_sub(self.count) {
                // A counter above the top turns round at once, or has all the way to MAX.
                None if dual => 1,
                None => u32::from(self.max()) - count + 1,
                Some(to_top @ 1..) if dual => u32::from(to_top),
                Some(to_top) => u32::from(to_top) + 1,
            }
        };
        for (channel, &compare) in self.compare.iter().enumerate() {
            let compare = u32::from(compare);
            let away = if self.down { count.checked_sub(compare) } else { compare.checked_sub(count) };
            if let Some(away) = away.filter(|_| channels >> channel & 1 == 1) {
                nearest = nearest.min(away + 1);
            }
        }
        nearest
    }

    /// One tick.
    pub(super) fn tick(&mut self) {
        let blocked = core::mem::take(&mut self.blocked);
        let (count, top) = (self.count, self.top());
        let matched = self.compare.map(|compare| compare == count && !blocked);
        let was_down = self.down;
        if self.mode().top == Top::Capture && count == top {
            self.flags |= CAPTURE;
        }
        for (channel, flag) in [(0, MATCH_A), (1, MATCH_B)] {
            if matched[channel] {
                self.flags |= flag;
            }
        }
        match self.mode().slope {
            Slope::Single => self.tick_single(top),
            Slope::Fast => self.tick_fast(top),
            Slope::Dual => self.tick_dual(top),
        }
        for (channel, matched) in matched.into_iter().enumerate() {
            self.output_tick(channel, matched, was_down, count, top);
        }
    }

    fn tick_single(&mut self, top: u16) {
        if self.count == self.max() {
            self.count = 0;
            self.flags |= OVERFLOW;
        } else if self.count == top {
            self.count = 0;
        } else {
            self.count += 1;
        }
    }

    fn tick_fast(&mut self, top: u16) {
        if self.count == top || self.count == self.max() {
            self.count = 0;
            self.flags |= OVERFLOW;
            self.compare = self.buffer;
        } else {
            self.count += 1;
        }
    }

    fn tick_dual(&mut self, top: u16) {
        if self.down && self.count > 0 {
            self.count -= 1;
        } else if self.count >= top {
            self.down = true;
            self.count = top.saturating_sub(1);
        } else {
            self.count += 1;
        }
        let update = self.mode().update;
        if self.count == 0 && self.down {
            self.down = false;
            self.flags |= OVERFLOW;
            if update == Update::Bottom {
                self.compare = self.buffer;
            }
        } else if self.count == top && !self.down && update == Update::Top {
            self.compare = self.buffer;
        }
    }

    /// The effect on a pin of the tick that has left `count`.
    fn output_tick(&mut self, channel: usize, matched: bool, was_down: bool, count: u16, top: u16) {
        let output = self.output(channel);
        match self.mode().slope {
            Slope::Single => {
                if matched {
                    self.apply(channel, output);
                }
            }
            Slope::Fast => {
                if matched {
                    self.apply(channel, output);
                }
                if self.count == 0 {
                    self.apply(channel, opposite(output));
                }
            }
            Slope::Dual if matched => {
                // At the ends the data sheet wants a constant level: at TOP that of counting down, at BOTTOM that of
                // counting up.
                let falling = if count == top { true } else { was_down && count != 0 };
                self.apply(channel, if falling { opposite_of_slope(output) } else { output });
            }
            Slope::Dual => {}
        }
    }

    pub(super) fn apply(&mut self, channel: usize, output: Output) {
        let bit = 1 << channel;
        match output {
            Output::Disconnected => {}
            Output::Toggle => self.latches ^= bit,
            Output::Clear => self.latches &= !bit,
            Output::Set => self.latches |= bit,
        }
    }
}

/// The action at BOTTOM in fast PWM.
const fn opposite(output: Output) -> Output {
    match output {
        Output::Disconnected | Output::Toggle => Output::Disconnected,
        Output::Clear => Output::Set,
        Output::Set => Output::Clear,
    }
}

/// The effect of a match on the way down.
const fn opposite_of_slope(output: Output) -> Output {
    match output {
        Output::Disconnected => Output::Disconnected,
        Output::Toggle => Output::Toggle,
        Output::Clear => Output::Set,
        Output::Set => Output::Clear,
    }
}

//! The dry run: the plan of a robot carried out without a world. There is no scene, no noise and no meaningful byte, only
//! tasks that fall due, bytes that travel and a brain that answers each message. Its results are the typical ones.
//!
//! It follows the same rules as `microcontroller`, `laptop` and `robot`, and uses the same lines.

use alloc::collections::VecDeque;
use alloc::vec;
use alloc::vec::Vec;

use super::device::{Ear, Watch};
use super::plan::{Plan, calm};
use super::report::Part;
use baudbot_sim::firmware::Mode;
use baudbot_sim::link::{Line, Link};
use baudbot_sim::model::Writes;
use baudbot_sim::schedule::Due;
use baudbot_sim::time::SimTime;

/// The result of the dry run.
#[derive(Clone, Debug, Default)]
pub(super) struct Outcome {
    /// The parts of each cycle that was completed, in nanoseconds, and their sum.
    pub(super) cycles: Vec<([u64; 9], u64)>,
    /// Ages of each sensor's readings, in nanoseconds.
    pub(super) ages: Vec<Vec<u64>>,
    /// Messages that arrived, commands that were obeyed, and steps of the brain.
    pub(super) messages: u64,
    pub(super) commands: u64,
    pub(super) steps: u64,
    /// The duration of its execution, in nanoseconds, and bytes that were sent up.
    pub(super) ran_ns: u64,
    pub(super) bytes_up: u64,
    /// Events that were carried out.
    pub(super) events: usize,
}

/// A message of readings, from the microcontroller to the brain.
#[derive(Clone, Debug)]
struct Sent {
    bytes: u64,
    tag: u8,
    arrived: u64,
    sampled: Vec<(usize, SimTime)>,
    cycle: Open,
}

/// A cycle that is not over yet.
#[derive(Clone, Copy, Debug, Default)]
struct Open {
    acquisition_ns: u64,
    framing_ns: u64,
    wire_ns: u64,
    closed: SimTime,
    delivered: SimTime,
    stepped: SimTime,
    written: SimTime,
}

/// A command on its way.
#[derive(Clone, Copy, Debug)]
struct Written {
    tag: u8,
    arrived: u64,
    cycle: Option<Open>,
}

/// The next task of the microcontroller.
enum Task {
    Read(usize),
    Send,
    Receive,
}

pub(super) struct Timeline<'a> {
    plan: Plan<'a>,
    link: Link,
    due: Vec<Due>,
    frame: Due,
    /// The last sample of each sensor, and whether it is in no message yet.
    samples: Vec<Option<(SimTime, bool)>>,
    watches: Vec<Option<Watch>>,
    ears: Vec<Ear>,
    free_at: SimTime,
    up: Line,
    down: Line,
    sent: VecDeque<Sent>,
    written: VecDeque<Written>,
    tags: (u8, u8),
    /// The newest message that the brain has not answered.
    news: Option<Option<Open>>,
    sampled: Vec<Option<SimTime>>,
    busy_until: SimTime,
    /// The brain's last step in which it wrote, and whether it owes an answer to a message that came before it might write again.
    wrote: Option<SimTime>,
    owes: bool,
    left: usize,
    outcome: Outcome,
}

impl<'a> Timeline<'a> {
    fn new(plan: Plan<'a>, events: usize) -> Self {
        let link = calm(&plan.spec.link);
        let sensors = plan.spec.sensors.len();
        let frame = match plan.spec.firmware.mode {
            Mode::Stream(schedule) => schedule.start(),
            Mode::Poll => Due { next: SimTime::NEVER, missed: 0 },
        };
        Self {
            due: plan.on_wire().iter().map(|sensor| sensor.schedule.start()).collect(),
            frame,
            samples: vec![None; plan.on_wire().len()],
            watches: plan.on_wire().iter().map(|sensor| Watch::of(sensor, plan.noise)).collect(),
            ears: plan.ports().map(|(i, sensor, _, link)| Ear::new(i, sensor, link, plan.noise)).collect(),
            free_at: SimTime::from_ns(plan.spec.processor.bootloader_ns),
            up: Line::up(&link, 1, &["budget:up"]),
            down: Line::down(&link, 1, &["budget:down"]),
            sent: VecDeque::new(),
            written: VecDeque::new(),
            tags: (0, 0),
            news: None,
            sampled: vec![None; sensors],
            busy_until: SimTime::ZERO,
            wrote: None,
            owes: false,
            left: events,
            outcome: Outcome { ages: vec![Vec::new(); sensors], ..Outcome::default() },
            link,
            plan,
        }
    }

    /// Carries it out until there are so many cycles, or so many events are over. It begins in the tick in which the
    /// firmware starts.
    pub(super) fn run(plan: Plan<'a>, cycles: usize, events: usize) -> Outcome {
        let mut timeline = Self::new(plan, events);
        let before = plan.spec.processor.bootloader_ns / plan.step_ns * plan.step_ns;
        let mut start = SimTime::from_ns(before);
        while timeline.outcome.cycles.len() < cycles && timeline.left > 0 {
            let end = start + plan.step_ns;
            timeline.tick(start, end);
            start = end;
        }
        timeline.outcome.ran_ns = start.as_ns() - before;
        timeline.outcome.events = events - timeline.left;
        timeline.outcome
    }

    fn tick(&mut self, start: SimTime, end: SimTime) {
        let earliest = self.busy_until.max(start);
        self.left = self.left.saturating_sub(1);
        if earliest < end {
            let at = self.advance(end, Some(earliest)).unwrap_or(end);
            self.step(at);
        }
        self.advance(end, None);
    }

    fn advance(&mut self, until: SimTime, earliest: Option<SimTime>) -> Option<SimTime> {
        let mut step = earliest.filter(|_| self.news.is_some());
        while self.left > 0 {
            let end = step.map_or(until, |at| at + 1);
            let (start, task) = self.next();
            let heard = self.ears.iter().map(Ear::next).min().unwrap_or(SimTime::NEVER);
            let arrival = self.up.arrival(&self.link).min(heard);
            if start.min(arrival) >= end {
                break;
            }
            self.left -= 1;
            if start <= arrival {
                self.serve(task, start);
                continue;
            }
            self.hear(arrival);
            if step.is_none() && self.news.is_some() {
                step = earliest.map(|earliest| earliest.max(arrival));
            }
        }
        step
    }

    fn next(&self) -> (SimTime, Task) {
        let mut next = (self.down.arrival(&self.link), Task::Receive);
        if self.frame.next <= next.0 {
            next = (self.frame.next, Task::Send);
        }
        for (i, due) in self.due.iter().enumerate().rev() {
            if due.next <= next.0 {
                next = (due.next, Task::Read(i));
            }
        }
        (next.0.max(self.free_at), next.1)
    }

    fn serve(&mut self, task: Task, now: SimTime) {
        match task {
            Task::Read(i) => {
                let sensor = &self.plan.spec.sensors[i];
                self.due[i].serve(&sensor.schedule, now);
                let measured = self.watches[i].as_ref().map_or(now, |watch| watch.held_at(now));
                self.samples[i] = Some((measured, true));
                self.free_at = now + self.plan.read_ns(sensor).middle();
            }
            Task::Send => self.send(now),
            Task::Receive => self.receive(now),
        }
    }

    fn send(&mut self, now: SimTime) {
        match self.plan.spec.firmware.mode {
            Mode::Stream(schedule) => _ = self.frame.serve(&schedule, now),
            Mode::Poll => self.frame.next = SimTime::NEVER,
        }
        self.up.claim_wire(&self.link, now, &mut self.down);
        let new = |i: usize| matches!(self.samples[i], Some((_, true)));
        let bytes = self.plan.readings_bytes(new);
        let framing_ns = self.plan.framing_ns(bytes);
        let bytes = self.plan.usual(bytes);
        let reads = self.plan.on_wire().iter().enumerate().filter(|(i, _)| new(*i));
        let acquisition_ns = reads.map(|(_, sensor)| self.plan.read_ns(sensor).middle()).sum();
        let in_it = |(_, new): (SimTime, bool)| new || self.plan.repeats();
        let sampled = self.samples.iter().enumerate();
        let sampled = sampled.filter_map(|(i, sample)| Some((i, sample.filter(|s| in_it(*s))?.0))).collect();
        self.samples.iter_mut().flatten().for_each(|sample| sample.1 = false);
        let closed = now + framing_ns;
        let wire_ns = self.link.burst_ns(bytes);
        let cycle = Open { acquisition_ns, framing_ns, wire_ns, closed, ..Open::default() };
        self.tags.0 = self.tags.0.wrapping_add(1);
        self.up.send(&self.link, closed, &vec![self.tags.0; bytes as usize]);
        self.sent.push_back(Sent { bytes, tag: self.tags.0, arrived: 0, sampled, cycle });
        self.outcome.bytes_up += bytes;
        self.free_at = closed.max(self.up.drained(&self.link));
        self.down.leave_wire_to(&self.link, &self.up);
    }

    fn receive(&mut self, now: SimTime) {
        self.down.overrun(&self.link, now);
        self.free_at = now + self.plan.receiving_ns();
        let Some((at, tag)) = self.down.take(&self.link, now) else { return };
        // Commands that lost bytes are never whole.
        while self.written.pop_front_if(|written| written.tag != tag).is_some() {}
        let Some(written) = self.written.front_mut() else { return };
        written.arrived += 1;
        if written.arrived < self.plan.usual(self.plan.command_bytes()) {
            return;
        }
        let cycle = written.cycle;
        self.written.pop_front();
        self.free_at = self.free_at + self.plan.spec.processor.obeying_ns;
        self.outcome.commands += 1;
        if self.plan.polls() {
            self.frame.next = self.frame.next.min(self.free_at);
        }
        if let Some(cycle) = cycle {
            self.close(cycle, at);
        }
    }

    /// The command that ends a cycle has arrived at `landed` and is obeyed.
    fn close(&mut self, cycle: Open, landed: SimTime) {
        let pulse = self.free_at.up_to(self.plan.pulse_ns());
        let mut parts = [0; 9];
        for (place, part) in Part::ALL.into_iter().enumerate() {
            parts[place] = match part {
                Part::Acquisition => cycle.acquisition_ns,
                Part::Framing => cycle.framing_ns,
                Part::WireUp => cycle.wire_ns,
                Part::WaitUp => cycle.delivered.since(cycle.closed).saturating_sub(cycle.wire_ns),
                Part::Step => cycle.stepped.since(cycle.delivered),
                Part::Thinking => cycle.written.since(cycle.stepped),
                Part::Down => landed.since(cycle.written),
                Part::Obeying => self.free_at.since(landed),
                Part::Actuation => pulse.since(self.free_at),
            };
        }
        self.outcome.cycles.push((parts, parts.iter().sum()));
    }

    fn hear(&mut self, now: SimTime) {
        for ear in &mut self.ears {
            if let Some((i, measured)) = ear.take(now) {
                self.sampled[i] = Some(measured);
                self.news = self.news.or(Some(None));
            }
        }
        while let Some((_, tag)) = self.up.take(&self.link, now) {
            while self.sent.pop_front_if(|sent| sent.tag != tag).is_some() {}
            let Some(sent) = self.sent.front_mut() else { continue };
            sent.arrived += 1;
            if sent.arrived < sent.bytes {
                continue;
            }
            for &(i, at) in &sent.sampled {
                self.sampled[i] = Some(at);
            }
            self.news = Some(Some(Open { delivered: now, ..sent.cycle }));
            self.outcome.messages += 1;
            self.sent.pop_front();
        }
    }

    /// The brain steps: what has come is news no more, and is answered.
    fn step(&mut self, at: SimTime) {
        self.outcome.steps += 1;
        for (ages, sampled) in self.outcome.ages.iter_mut().zip(&mut self.sampled) {
            ages.extend(sampled.take().map(|sampled| at.since(sampled)));
        }
        let thinking_ns = self.plan.thinking().typical_ns;
        let mut written = at + thinking_ns;
        if self.plan.spec.is_onboard() {
            written = self.free_at.max(at) + thinking_ns;
            self.free_at = written;
        }
        self.busy_until = written;
        let news = self.news.take();
        if !self.writes_now(at, news.is_some()) {
            return;
        }
        self.wrote = Some(at);
        self.write(written, news.flatten().map(|cycle| Open { stepped: at, written, ..cycle }));
        for _ in 1..self.plan.commands_in_a_turn() {
            self.write(written, None);
        }
    }

    /// Whether the brain writes in its step.
    fn writes_now(&mut self, at: SimTime, has_news: bool) -> bool {
        let pause_ns = self.plan.pause_ns();
        let is_free = self.wrote.is_none_or(|wrote| at.since(wrote) >= pause_ns);
        // The first word of a polled robot is the brain's.
        let asks = self.plan.polls() && self.outcome.steps == 1;
        match self.plan.writes() {
            Writes::OnMessage => has_news || asks,
            Writes::EveryTick => true,
            Writes::AtMost(_) => is_free,
            Writes::WhenFree => {
                self.owes |= has_news || asks;
                is_free && core::mem::take(&mut self.owes)
            }
        }
    }

    fn write(&mut self, at: SimTime, cycle: Option<Open>) {
        let bytes = self.plan.usual(self.plan.command_bytes());
        let waiting = self.down.waiting(&self.link, at) as u64;
        if waiting + bytes > self.link.laptop_buffer() as u64 {
            return;
        }
        self.tags.1 = self.tags.1.wrapping_add(1);
        self.down.send(&self.link, at, &vec![self.tags.1; bytes as usize]);
        self.written.push_back(Written { tag: self.tags.1, arrived: 0, cycle });
    }
}

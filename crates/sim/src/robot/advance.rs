//! A robot's timeline within a tick: its devices, its microcontroller and its cables, one event after the other.
//!
//! There is no event queue. Each part knows when its next event is due, and [`Robot::advance`] picks the earliest of them,
//! because most events change when others are due: a sensor that is read keeps the microcontroller busy, so the next frame
//! is late; a frame keeps the wire busy, so a byte of the next one arrives later. A queue would hold stale entries.
//!
//! Events at the same instant have a fixed order, since the same inputs must give the same bits:
//!
//! 1. devices with a clock of their own, so that the microcontroller finds a value that is ready at that instant;
//! 2. the microcontroller: sensors in their order, then sending, then receiving;
//! 3. devices that answer on ports of their own, in the order of the ports;
//! 4. bytes at the laptop, so that over an ideal link a reading arrives at the instant at which it is sent;
//! 5. the brain's step, which has thus seen all that happened at its instant.

use super::measurement::measurement;
use super::{Robot, Tick};
use crate::drive::Wheels;
use crate::link::Message;
use crate::microcontroller::{Condition, Order, Taken, Task};
use crate::model::{OnLate, PortUse, RobotSpec};
use crate::sensor::Event;
use crate::time::SimTime;
use crate::timeline::What;

/// The next event on a robot.
enum Next {
    /// A device with an own clock.
    Device(usize, Event),
    /// The microcontroller.
    Task(Task),
    /// A device that answers on a port of its own.
    Dialogue(usize),
    /// A chip with a program of the user's own.
    Chip,
}

impl Robot {
    /// The brain steps at `at`, in this tick: it has now been given all that arrived.
    pub(crate) fn hand_over(&mut self, tick: u64, at: SimTime, step_ns: u64) {
        self.laptop.hand_over(tick, at);
        self.writes.begin_step(at, step_ns);
        for port in &mut self.ports {
            port.clear();
        }
    }

    /// Runs the cable from the start of the tick up to the brain's step, and returns when that is. In a run that has
    /// `ended` the sensors are read a last time, and no brain steps.
    pub(crate) fn listen(&mut self, spec: &RobotSpec, tick: &Tick<'_>, ended: bool) -> Option<SimTime> {
        let (now, end) = (tick.start, tick.end);
        self.laptop.truth.begin_tick();
        self.note_faults(spec, now, end);
        let earliest = self.laptop.busy_until.max(now);
        if ended {
            self.advance(spec, tick, now + 1, None);
            return None;
        }
        match spec.port_use {
            PortUse::Closed => self.listen_for_brain(spec, tick, earliest),
            PortUse::Open => {
                // A port reads on until the tick is over, whatever comes; brains' thinking and stalls are none of its.
                self.advance(spec, tick, end, None);
                self.counters.turns += 1;
                Some(end)
            }
            PortUse::Simulated => {
                self.forget_arrived();
                self.advance(spec, tick, now + 1, None);
                None
            }
        }
    }

    /// The brain's step is not before `earliest`.
    fn listen_for_brain(
        &mut self,
        spec: &RobotSpec,
        tick: &Tick<'_>,
        mut earliest: SimTime,
    ) -> Option<SimTime> {
        let (now, end) = (tick.start, tick.end);
        // The brain steps when a message has come, in the first stretch of time in which it does not stall.
        let step = loop {
            earliest = spec.awake_from(earliest, end);
            if earliest >= end {
                self.advance(spec, tick, now + 1, None);
                return None;
            }
            let stall = spec.stalls().filter_map(|when| when.begins_within(earliest, end + 1)).min();
            let until = stall.map_or(end, |(from, _)| from);
            match (self.advance(spec, tick, until.min(end), Some(earliest)), stall) {
                (Some(at), _) => break at,
                (None, None) => break end,
                (None, Some((_, until))) => earliest = until,
            }
        };
        self.counters.turns += 1;
        Some(step)
    }

    /// Runs the timeline of microcontroller and link through all that happens before `until`. With `earliest`, stops
    /// when the brain can step, which is when a message has arrived, for a program in simulated time a byte, and `earliest` is
    /// reached, and returns when that is; what happens at that very instant has then happened.
    pub(crate) fn advance(
        &mut self,
        spec: &RobotSpec,
        tick: &Tick<'_>,
        until: SimTime,
        earliest: Option<SimTime>,
    ) -> Option<SimTime> {
        let mut step = earliest.filter(|_| self.has_news(spec));
        // The next event on the robot is kept while bytes arrive at the laptop, which change nothing on the robot: on a fast
        // cable most events are such bytes.
        let mut on_robot = self.next_on_robot(spec);
        loop {
            // Once the step's instant is known, the rest of that instant happens and nothing later.
            let end = step.map_or(until, |at| at + 1);
            let (arrival, port) = self.next_byte(spec);
            if on_robot.0.min(arrival) >= end {
                return step;
            }
            if on_robot.0 <= arrival {
                let (now, next) = on_robot;
                let soon = self.run_next(spec, tick, now, (next, end, earliest.is_some() && step.is_none()));
                on_robot = soon.map_or_else(|| self.next_on_robot(spec), |(at, task)| (at, Next::Task(task)));
                // On board there is nothing to arrive.
                if step.is_none() && self.has_news(spec) {
                    step = earliest.map(|earliest| earliest.max(now));
                }
                continue;
            }
            let mut heard = arrival;
            if let Some(port) = port {
                // An answer that the laptop's driver receives may make it write.
                if self.hear_port(spec, arrival, port) {
                    on_robot = self.next_on_robot(spec);
                }
            } else {
                heard = self.hear(spec, arrival, on_robot.0.min(end));
            }
            if step.is_none() && self.has_news(spec) {
                step = earliest.map(|earliest| earliest.max(heard));
            }
        }
    }

    /// Does what comes next; returns what comes behind it, if that is known without looking at all there is. A chip
    /// runs until `end` at most.
    #[inline]
    fn run_next(
        &mut self,
        spec: &RobotSpec,
        tick: &Tick<'_>,
        now: SimTime,
        (next, end, may_step): (Next, SimTime, bool),
    ) -> Option<(SimTime, Task)> {
        match next {
            Next::Device(i, event) => self.run_device(spec, tick, now, (i, event)),
            Next::Task(task) => return self.run(spec, tick, now, task),
            Next::Dialogue(k) => self.run_dialogue(spec, now, k),
            Next::Chip => self.run_chip(spec, tick, end, may_step),
        }
        None
    }

    /// The next event on the robot, and its instant; of two at one instant, a device, and of two devices the first.
    #[inline(always)]
    fn next_on_robot(&self, spec: &RobotSpec) -> (SimTime, Next) {
        let mut next = if let Some(chip) = &self.parts.chip {
            (chip.now(), Next::Chip)
        } else {
            let (start, task) = self.microcontroller.next(&spec.link, &self.downlink);
            (start, Next::Task(task))
        };
        for &i in spec.sensors.own_clocks() {
            let (at, event) = self.microcontroller.next_of_own(i, &spec.sensors[i]);
            if at <= next.0 && !(at == next.0 && matches!(next.1, Next::Device(..))) {
                next = (at, Next::Device(i, event));
            }
        }
        if self.parts.dialogues.is_some()
            && let Some((at, k)) = self.next_of_dialogues(spec)
            && at < next.0
        {
            next = (at, Next::Dialogue(k));
        }
        next
    }

    /// Does a task; returns what comes next, if that is known without looking at all there is.
    #[inline(never)]
    fn run(
        &mut self,
        spec: &RobotSpec,
        tick: &Tick<'_>,
        now: SimTime,
        task: Task,
    ) -> Option<(SimTime, Task)> {
        match task {
            Task::Acquire(i) => return self.acquire(spec, tick, now, i),
            Task::SendReadings => self.send_readings(spec, now),
            Task::Receive => self.receive(spec, now),
        }
        None
    }

    /// Reads sensor `first` and those behind it that are due at the same instant, as long as reading takes no time.
    #[inline(never)]
    fn acquire(
        &mut self,
        spec: &RobotSpec,
        tick: &Tick<'_>,
        now: SimTime,
        first: usize,
    ) -> Option<(SimTime, Task)> {
        let Self { microcontroller, motion, actuators, parts, pings, recorder, .. } = self;
        let mut at = measurement(spec, tick, now, (motion, actuators, parts));
        let next = microcontroller.acquire(spec, first, &mut at, |acquired| {
            let sensor = acquired.sensor as u16;
            if acquired.ping.is_some() {
                pings[0] = acquired.ping;
            }
            if acquired.has_missed {
                recorder.note(now, now, What::Missed { sensor });
            }
            recorder.note(now, acquired.until, What::Acquire { sensor });
        });
        next.map(|(start, behind)| (start, Task::Acquire(behind)))
    }

    #[inline(never)]
    fn receive(&mut self, spec: &RobotSpec, now: SimTime) {
        let taken = self.microcontroller.receive(spec, now, &mut self.downlink);
        self.recorder.receive(now, taken, self.microcontroller.free_at());
        let Taken::Command(at) = taken else { return };
        if let Some(begun) = self.downlink.cycle_of_last_byte()
            && self.cycles.close(&spec.deadline, begun, spec.drive.motor.takes_effect(at))
        {
            let is_empty = || self.downlink.waiting(&spec.link, at) == 0;
            self.cycles.exceptions.cycles += u64::from(self.writes.close(is_empty));
        }
    }

    #[inline(never)]
    fn send_readings(&mut self, spec: &RobotSpec, now: SimTime) {
        let missed = self.microcontroller.frames_missed();
        if spec.hands_over() {
            self.tell(spec, now);
        } else {
            self.send_message(spec, now);
        }
        if self.microcontroller.frames_missed() != missed {
            self.recorder.note(now, now, What::Missed { sensor: u16::MAX });
        }
    }

    fn send_message(&mut self, spec: &RobotSpec, now: SimTime) {
        let Self { microcontroller, uplink, laptop, .. } = self;
        if let Some((bytes, begun)) = microcontroller.send_at_once(spec, now, uplink, laptop) {
            self.cycles.open(begun);
            let bytes = bytes as u32;
            self.recorder.note(now, now, What::Frame { bytes });
            self.recorder.note(now, now, What::Up { bytes });
            return;
        }
        self.uplink.claim_wire(&spec.link, now, &mut self.downlink);
        let spare = core::mem::take(&mut self.spare);
        let battery = self.parts.battery.as_ref();
        let robot = Condition { motion: &self.motion, signals: self.signals, battery };
        let sent = self.microcontroller.send_readings(spec, now, &mut self.uplink, &robot, spare);
        self.downlink.leave_wire_to(&spec.link, &self.uplink);
        if let Some(begun) = sent.cycle {
            self.cycles.open(begun);
        }
        let bytes = sent.bytes;
        // A mere acknowledgement of a command is no message of readings.
        if sent.cycle.is_some() {
            self.recorder.note(now, sent.closed, What::Frame { bytes });
        }
        let free = self.microcontroller.free_at();
        if free > sent.closed {
            self.recorder.note(sent.closed, free, What::Block);
        }
        self.recorder.note(sent.on_wire.0, sent.on_wire.1, What::Up { bytes });
    }

    #[inline(never)]
    fn run_device(&mut self, spec: &RobotSpec, tick: &Tick<'_>, now: SimTime, (i, event): (usize, Event)) {
        match event {
            Event::Measure => {
                let Self { microcontroller, motion, actuators, parts, .. } = self;
                let at = measurement(spec, tick, now, (motion, actuators, parts));
                microcontroller.measure(spec, i, &at);
            }
            Event::Output => {
                if let Some(begun) = self.microcontroller.pending_since(i) {
                    self.recorder.note(begun, now, What::Measure { sensor: i as u16 });
                }
                self.send_output(spec, now, i);
            }
        }
    }

    /// Takes the bytes that arrive at the laptop from `first` on, up to the first message since the brain's last step
    /// and `before` anything else happens. Returns when the last of them came.
    #[inline(never)]
    fn hear(&mut self, spec: &RobotSpec, first: SimTime, before: SimTime) -> SimTime {
        let alone = self.ports.is_empty() && self.uplink.is_direct();
        let last = if alone { SimTime::from_ns(before.as_ns() - 1) } else { first };
        let had_news = self.has_news(spec);
        let mut now = first;
        while self.has_news(spec) == had_news
            && let Some((at, byte)) = self.uplink.take(&spec.link, last)
        {
            now = at.max(first);
            let message = self.laptop.receive(spec, (at, byte), &mut self.uplink);
            let Some(Message { on_wire_until, sampled, .. }) = message else { continue };
            self.spare = sampled;
            if on_wire_until < now {
                self.recorder.note(on_wire_until, now, What::Adapter);
            }
        }
        now
    }

    /// The events of this tick are over, and the robot begins to move.
    pub(crate) fn start_moving(&mut self, spec: &RobotSpec, noise: bool) {
        self.collided = false;
        self.pings = [None, self.pings[0].or(self.pings[1])];
        if noise {
            self.motor_noise.tick(&spec.drive.motor_noise);
        }
    }

    /// The faults that come into force from `now` until `end`.
    pub(crate) fn note_faults(&mut self, spec: &RobotSpec, now: SimTime, end: SimTime) {
        for (i, fault) in spec.faults.iter().enumerate() {
            let mut from = now;
            while let Some((begun, until)) = fault.when.begins_within(from, end) {
                self.recorder.note(begun, until, What::Fault { fault: i as u16 });
                from = begun + 1;
            }
        }
    }

    /// Losses on the cables are counted when a tick ends.
    pub(crate) fn look_for_losses(&mut self, now: SimTime) {
        let lost = self.lost();
        self.recorder.note_losses(now, lost);
    }

    /// Bytes that were lost on all its cables so far.
    pub(crate) fn lost(&self) -> u64 {
        let cables =
            [&self.uplink, &self.downlink].into_iter().chain(self.ports.iter().map(|port| &port.line));
        let dialogues = self.parts.dialogues.iter().flatten().flatten();
        let cables = cables.chain(dialogues.map(|dialogue| &dialogue.down));
        cables.map(|line| line.counters.lost()).sum()
    }

    /// The actuators take up what has been commanded by `now`, and what is late is found out.
    pub(crate) fn take_up(&mut self, spec: &RobotSpec, now: SimTime, dt: f64) {
        if self.parts.chip.is_some() {
            return self.take_up_from_chip(spec, now, dt);
        }
        let mut stopped_at = None;
        while let Some(due) = self.cycles.settle(&spec.deadline, now) {
            self.recorder.note(due, due, What::Late);
            stopped_at = stopped_at.max((spec.deadline.on_late == Some(OnLate::Stop)).then_some(due));
        }
        if stopped_at.is_some() {
            self.signals = Wheels::default();
            self.microcontroller.stand();
        }
        let until = spec.drive.motor.obeys_until(now);
        if let Some(Order { at, signals, others }) = self.microcontroller.order_at(until) {
            // Commands from before the stop of the motors do not start them again.
            if stopped_at.is_none_or(|stopped_at| spec.drive.motor.takes_effect(at) > stopped_at) {
                self.signals = signals;
            }
            self.commanded_at = at;
            for (actuator, signal) in self.actuators.iter_mut().zip(others) {
                actuator.signal = signal;
            }
            self.recorder.note(now, now, What::Act);
        }
        let battery = self.parts.battery.as_ref();
        let robot = Condition { motion: &self.motion, signals: self.signals, battery };
        if let Some((since, signals)) = self.microcontroller.steer(spec, &robot, now, dt) {
            self.signals = signals;
            self.commanded_at = self.commanded_at.max(since);
        }
        if spec.command_timeout_ns.is_some_and(|timeout| now.since(self.commanded_at) >= timeout) {
            self.signals = Wheels::default();
        }
    }
}

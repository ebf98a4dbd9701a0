//! The state of the Open Interface of an iRobot Create: its mode, what was asked for, what is played and shown.
//!
//! `microcontroller/create.rs` binds it to the robot.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use baudbot_wire::create::{
    BAUDS, Command, Commands, FULL_MM_S, MOST_STREAMED, Mode, Version, group, listed_len, stream_len,
};
use serde::{Deserialize, Serialize};

use crate::sound;
use crate::time::{SECOND_NS, SimTime};

/// The state of the interface.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct OpenInterface {
    pub(crate) version: Version,
    commands: Commands,
    pub(crate) mode: Mode,
    /// Numbers of packets and groups that are to be sent once.
    asked: VecDeque<u8>,
    /// The text of the boot is to be sent.
    pub(crate) boots: bool,
    /// Bytes before this instant, while it boots, are lost.
    pub(crate) deaf_until: SimTime,
    streamed: Vec<u8>,
    is_paused: bool,
    /// The instant at which the stream is due, while there is one.
    pub(crate) due: SimTime,
    /// Velocity and radius; right and left velocity. As they were last asked for, in mm/s and mm.
    pub(crate) requested: [i16; 2],
    pub(crate) requested_wheels: [i16; 2],
    /// The length of each song, in 1/64 s.
    songs: [Option<u16>; MOST_SONGS],
    pub(crate) song: u8,
    plays_until: SimTime,
    shown: Shown,
    /// Way and turn that have been sent, in mm and degrees.
    pub(crate) told: [i64; 2],
    /// The baud rate that the cable is to have from the end of the tick on.
    baud: Option<u32>,
    /// The robot was lifted, so that its wheels have dropped, since the interface last checked.
    pub(crate) was_lifted: bool,
}

/// The switches and lights, which move nothing here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Shown {
    motors: u8,
    pulse_widths: [u8; 3],
    leds: [u8; 3],
    clock_leds: [u8; 2],
    digits: [u8; 4],
}

/// The effect of a command on the rest of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Deed {
    /// The command was not obeyed.
    Refused,
    /// The command needs no deed, or an answer is owed now.
    Nothing,
    /// The wheels turn so that the centre has this velocity, in mm/s, on this radius, in mm.
    Turns([i16; 2]),
    /// The left and the right wheel turn with these shares of full signal.
    Rolls([f64; 2]),
    /// The wheels stand.
    Stands,
    /// The processor starts again.
    Boots,
    /// There is a stream from now on.
    Streams,
}

const MOST_SONGS: usize = 16;

/// Most packets and groups that wait to be sent. Requests beyond that are dropped (a guess).
const MOST_ASKED: usize = 256;

/// 1/64 s, in nanoseconds.
const BEAT_NS: u64 = SECOND_NS / 64;

impl OpenInterface {
    /// An `OpenInterface` of a robot that has been switched on.
    pub(crate) fn new(version: Version) -> Self {
        Self {
            version,
            commands: Commands::new(version),
            mode: Mode::Off,
            asked: VecDeque::new(),
            boots: false,
            deaf_until: SimTime::ZERO,
            streamed: Vec::new(),
            is_paused: false,
            due: SimTime::NEVER,
            requested: [0; 2],
            requested_wheels: [0; 2],
            songs: [None; MOST_SONGS],
            song: 0,
            plays_until: SimTime::ZERO,
            shown: Shown::default(),
            told: [0; 2],
            baud: None,
            was_lifted: false,
        }
    }

    /// The baud rate that a command has asked for since this was last called.
    pub(crate) fn take_baud(&mut self) -> Option<u32> {
        self.baud.take()
    }

    /// Takes the next byte from the wire. Gives the bytes of the command that the byte ends.
    pub(crate) fn push(&mut self, byte: u8) -> Option<&[u8]> {
        self.commands.push(byte)
    }

    /// Whether this may have become what `other` is.
    pub(crate) fn may_become(&self, other: &Self) -> bool {
        let is_known = |id: &u8| group(self.version, *id).is_some();
        self.version == other.version
            && self.commands.may_become(&other.commands)
            && other.asked.len() <= MOST_ASKED
            && other.asked.iter().chain(&other.streamed).all(is_known)
            && stream_len(self.version, &other.streamed) <= MOST_STREAMED + 3
            && other.songs.iter().flatten().all(|beats| *beats <= 16 * 255)
            && usize::from(other.song) < MOST_SONGS
            && sound::numbers(other.told.map(|told| told as f64))
            && other.baud.is_none_or(|baud| BAUDS.contains(&baud))
    }

    /// Obeys a command that was taken at `now`, as far as that is inside the interface.
    pub(crate) fn obey(&mut self, command: Command<'_>, now: SimTime) -> Deed {
        if self.mode < command.least_mode() {
            return Deed::Refused;
        }
        match command {
            Command::Start | Command::Power | Command::Demo(_) => self.stand_in(Mode::Passive),
            Command::Stop => self.stand_in(Mode::Off),
            Command::Safe => self.rise_to(Mode::Safe),
            Command::Full => self.rise_to(Mode::Full),
            Command::Reset => {
                *self = Self { boots: true, told: self.told, ..Self::new(self.version) };
                Deed::Boots
            }
            Command::Drive { velocity_mm_s, radius_mm } => {
                let most = FULL_MM_S as i16;
                self.requested = [velocity_mm_s.clamp(-most, most), radius_mm];
                Deed::Turns([velocity_mm_s, radius_mm])
            }
            Command::DriveDirect { right_mm_s, left_mm_s } => self.roll(right_mm_s, left_mm_s),
            Command::DrivePwm { right, left } => {
                Deed::Rolls([left, right].map(|width| f64::from(width) / 255.0))
            }
            Command::Sensors(id) => self.ask(&[id]),
            Command::QueryList(ids) => self.ask(ids),
            Command::Stream(ids) => self.stream(ids),
            Command::Resume(resumes) => self.resume(resumes),
            Command::Song { number, notes } => self.keep(number, notes),
            Command::Play(number) => self.play(number, now),
            Command::Motors(bits) => show(&mut self.shown.motors, bits),
            Command::MotorsPwm(widths) => show(&mut self.shown.pulse_widths, widths),
            Command::Leds(leds) => show(&mut self.shown.leds, leds),
            Command::ClockLeds(leds) => show(&mut self.shown.clock_leds, leds),
            Command::Digits(digits) | Command::Characters(digits) => show(&mut self.shown.digits, digits),
            Command::Baud(code) => {
                self.baud = BAUDS.get(usize::from(code)).copied();
                Deed::Nothing
            }
            Command::Without(_) => Deed::Nothing,
        }
    }

    /// The interface goes into a mode in which nothing moves.
    pub(crate) fn stand_in(&mut self, mode: Mode) -> Deed {
        let moved = self.mode >= Mode::Safe;
        self.mode = mode;
        (self.requested, self.requested_wheels) = ([0; 2], [0; 2]);
        if mode == Mode::Off {
            self.streamed.clear();
            self.asked.clear();
        }
        if moved { Deed::Stands } else { Deed::Nothing }
    }

    fn rise_to(&mut self, mode: Mode) -> Deed {
        self.mode = mode;
        Deed::Nothing
    }

    fn roll(&mut self, right_mm_s: i16, left_mm_s: i16) -> Deed {
        let most = FULL_MM_S as i16;
        self.requested_wheels = [right_mm_s, left_mm_s].map(|speed| speed.clamp(-most, most));
        Deed::Rolls([left_mm_s, right_mm_s].map(|speed| f64::from(speed) / FULL_MM_S))
    }

    fn resume(&mut self, resumes: bool) -> Deed {
        self.is_paused = !resumes;
        if self.streams() { Deed::Streams } else { Deed::Nothing }
    }

    fn ask(&mut self, ids: &[u8]) -> Deed {
        let known = ids.iter().copied().filter(|id| group(self.version, *id).is_some());
        self.asked.extend(known.take(MOST_ASKED - self.asked.len()));
        Deed::Nothing
    }

    /// A stream of these packets from now on. Those that it has no room for are left out (a guess).
    fn stream(&mut self, ids: &[u8]) -> Deed {
        self.streamed.clear();
        self.is_paused = false;
        for &id in ids.iter().filter(|id| group(self.version, **id).is_some()) {
            self.streamed.push(id);
            if stream_len(self.version, &self.streamed) > MOST_STREAMED + 3 {
                self.streamed.pop();
            }
        }
        if self.streams() { Deed::Streams } else { Deed::Nothing }
    }

    /// Keeps a song; one without notes is none.
    fn keep(&mut self, number: u8, notes: &[u8]) -> Deed {
        if number < self.version.songs() {
            let beats = notes.chunks_exact(2).map(|note| u16::from(note[1])).sum();
            self.songs[usize::from(number)] = (!notes.is_empty()).then_some(beats);
        }
        Deed::Nothing
    }

    /// Begins to play a song, unless one is played.
    fn play(&mut self, number: u8, now: SimTime) -> Deed {
        let beats = self.songs.get(usize::from(number)).copied().flatten();
        if let Some(beats) = beats.filter(|_| !self.plays(now)) {
            self.song = number;
            self.plays_until = now + u64::from(beats) * BEAT_NS;
        }
        Deed::Nothing
    }

    /// Whether a song is played.
    pub(crate) fn plays(&self, now: SimTime) -> bool {
        now < self.plays_until
    }

    /// Whether something is to be sent at once.
    pub(crate) fn owes(&self) -> bool {
        self.boots || !self.asked.is_empty()
    }

    /// Whether there is a stream.
    pub(crate) fn streams(&self) -> bool {
        !self.is_paused && !self.streamed.is_empty()
    }

    /// The packets and groups of the stream.
    pub(crate) fn streamed(&self) -> &[u8] {
        &self.streamed
    }

    /// The packets and groups that are sent next, in `room` bytes; they are owed no more.
    pub(crate) fn settle(&mut self, room: usize) -> Vec<u8> {
        let (version, mut len) = (self.version, 0);
        let fits = |id: &&u8| {
            len += listed_len(version, &[**id]);
            len <= room
        };
        let count = self.asked.iter().take_while(fits).count();
        self.asked.drain(..count).collect()
    }
}

/// Something else is switched or shown from now on.
fn show<T>(shown: &mut T, new: T) -> Deed {
    *shown = new;
    Deed::Nothing
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(commands: &[Command<'_>]) -> OpenInterface {
        let mut interface = OpenInterface::new(Version::Two);
        for command in commands {
            interface.obey(*command, SimTime::ZERO);
        }
        interface
    }

    #[test]
    fn the_modes_follow_their_commands() {
        use Command::{Demo, Full, Power, Safe, Start, Stop};
        for (commands, mode) in [
            (&[][..], Mode::Off),
            (&[Full, Safe, Power, Demo(135)], Mode::Off),
            (&[Start], Mode::Passive),
            (&[Start, Safe], Mode::Safe),
            (&[Start, Full], Mode::Full),
            (&[Start, Full, Safe], Mode::Safe),
            (&[Start, Full, Start], Mode::Passive),
            (&[Start, Safe, Power], Mode::Passive),
            (&[Start, Safe, Demo(134)], Mode::Passive),
            (&[Start, Full, Stop], Mode::Off),
        ] {
            assert_eq!(after(commands).mode, mode, "{commands:?}");
        }
    }

    #[test]
    fn what_moves_or_shines_needs_safe_or_full() {
        let drive = Command::DriveDirect { right_mm_s: 1, left_mm_s: 1 };
        for command in [drive, Command::Leds([1; 3]), Command::Play(0), Command::Motors(1)] {
            for (mode, obeyed) in
                [(Mode::Off, false), (Mode::Passive, false), (Mode::Safe, true), (Mode::Full, true)]
            {
                let mut interface = OpenInterface { mode, ..OpenInterface::new(Version::Two) };
                let refused = interface.obey(command, SimTime::ZERO) == Deed::Refused;
                assert_eq!(!refused, obeyed, "{command:?} in {mode:?}");
            }
        }
    }

    #[test]
    fn a_song_is_played_for_its_beats_and_no_other_meanwhile() {
        let mut interface = after(&[
            Command::Start,
            Command::Full,
            Command::Song { number: 2, notes: &[60, 32, 64, 32] },
            Command::Song { number: 3, notes: &[60, 1] },
            Command::Song { number: 5, notes: &[60, 1] },
            Command::Play(2),
            Command::Play(3),
            Command::Play(4),
        ]);
        let second = SimTime::from_ns(SECOND_NS);
        assert!(interface.plays(SimTime::from_ns(SECOND_NS - 1)) && !interface.plays(second));
        assert_eq!(interface.song, 2);
        assert_eq!(interface.songs[5], None, "a Create 2 has five songs");
        interface.obey(Command::Play(3), second);
        assert_eq!((interface.song, interface.plays(second)), (3, true));
    }

    #[test]
    fn no_list_is_longer_than_what_there_is_room_for() {
        let many = [100; 255];
        let mut interface = after(&[Command::Start, Command::Stream(&many)]);
        assert_eq!(interface.streamed(), [100; 3]);
        interface.obey(Command::Stream(&[200, 7, 99, 8]), SimTime::ZERO);
        assert_eq!(interface.streamed(), [7, 8]);
        for _ in 0..10 {
            interface.obey(Command::QueryList(&many), SimTime::ZERO);
        }
        assert_eq!(interface.asked.len(), MOST_ASKED);
        assert_eq!(interface.settle(250), [100; 3]);
        assert!(OpenInterface::new(Version::Two).may_become(&interface));
        assert!(!OpenInterface::new(Version::One).may_become(&interface));
    }
}

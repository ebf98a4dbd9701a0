//! Digests: short fingerprints, tick by tick, of the values of a world that are cheap to read.
//!
//! If a replay ends in another state, the state's fingerprint does not say where the difference began. So every tick has
//! 16 bits for each field, over all robots, and for each robot, over all fields. Values that a world does not know yet while
//! it is ahead of its brains are in none of them.

use baudbot_proto::v1;
use baudbot_sim::{RobotView, World};

/// The fields, in the order of their digests.
pub(crate) const FIELDS: [&str; 9] =
    ["pose", "speed", "motor signals", "samples", "readings", "cable", "battery", "actuators", "things"];

/// Robots beyond so many share their places.
const PLACES: usize = 64;

/// The digests of some ticks in a row.
#[derive(Debug, Default)]
pub struct Digests {
    first_tick: u64,
    fields: Vec<u8>,
    robots: Vec<u8>,
}

impl Digests {
    /// Adds the digest of a world whose tick has begun.
    pub fn note(&mut self, world: &World) {
        if self.fields.is_empty() {
            self.first_tick = world.tick();
        }
        let (fields, robots) = digests(world);
        self.fields.extend(fields.iter().flat_map(|digest| digest.to_le_bytes()));
        self.robots.extend(robots.iter().flat_map(|digest| digest.to_le_bytes()));
    }

    /// A mark with all of them, at the tick of a world that need not have begun: as it will be when it has.
    pub fn last_mark(&mut self, world: &World) -> v1::RecordedMark {
        let mut begun = world.clone();
        begun.begin();
        if self.last_tick() != Some(begun.tick()) {
            self.note(&begun);
        }
        self.mark(&begun)
    }

    /// Ticks since the last mark.
    pub fn ticks(&self) -> u64 {
        (self.fields.len() / (2 * FIELDS.len())) as u64
    }

    fn last_tick(&self) -> Option<u64> {
        Some(self.first_tick + self.ticks().checked_sub(1)?)
    }

    /// A mark with all of them, at a tick that has begun; the next ones are of ticks after it.
    pub fn mark(&mut self, world: &World) -> v1::RecordedMark {
        let Self { first_tick, fields, robots } = std::mem::take(self);
        v1::RecordedMark {
            tick: world.tick(),
            state_hash: world.hash(),
            first_tick,
            fields: FIELDS.map(str::to_owned).to_vec(),
            field_digests: fields,
            robot_digests: robots,
        }
    }
}

/// A mark as it is compared with a world.
#[derive(Debug)]
pub(crate) struct Mark {
    pub(crate) tick: u64,
    pub(crate) first_tick: u64,
    pub(crate) state_hash: u64,
    /// The digests of its ticks, one after the other; none if they are of other fields than are known here.
    fields: Vec<u8>,
    robots: Vec<u8>,
}

impl Mark {
    /// The bytes that it has on the heap.
    pub(crate) fn heap_bytes(&self) -> usize {
        self.fields.capacity() + self.robots.capacity()
    }
}

impl From<v1::RecordedMark> for Mark {
    fn from(mark: v1::RecordedMark) -> Self {
        let v1::RecordedMark { tick, first_tick, state_hash, .. } = mark;
        let (mut fields, mut robots) = (mark.field_digests, mark.robot_digests);
        if mark.fields != FIELDS {
            (fields, robots) = Default::default();
        }
        Self { tick, first_tick, state_hash, fields, robots }
    }
}

/// The first field that is not what it was when this mark was made, at this tick; if only one robot can be meant, with
/// its name. `None` if all is the same, or the mark knows nothing of it.
pub(crate) fn difference(mark: &Mark, world: &World) -> Option<String> {
    let place = usize::try_from(world.tick().checked_sub(mark.first_tick)?).ok()?;
    let (fields, robots) = digests(world);
    let recorded = |all: &[u8], n: usize, i: usize| {
        let at = place.checked_mul(n)?.checked_add(i)?.checked_mul(2)?;
        Some(u16::from_le_bytes(all.get(at..at.checked_add(2)?)?.try_into().ok()?))
    };
    let is_other = |all: &[u8], digests: &[u16], i: usize| {
        recorded(all, digests.len(), i).is_some_and(|digest| digest != digests[i])
    };
    let field = (0..fields.len()).find(|&i| is_other(&mark.fields, &fields, i));
    let robot = (0..robots.len()).find(|&i| is_other(&mark.robots, &robots, i));
    let names = |i: usize| {
        let names = world.robots().skip(i).step_by(PLACES).map(|robot| robot.spec().name.clone());
        names.collect::<Vec<_>>().join(" or ")
    };
    match (robot.map(names), field) {
        (Some(robot), Some(field)) => Some(format!("`{robot}`: {}", FIELDS[field])),
        (Some(robot), None) => Some(format!("`{robot}`")),
        (None, Some(field)) => Some(FIELDS[field].to_owned()),
        (None, None) => None,
    }
}

fn digests(world: &World) -> ([u16; FIELDS.len()], Vec<u16>) {
    let mut fields = [Mixer::default(); FIELDS.len()];
    let mut robots = vec![Mixer::default(); world.robots().len().min(PLACES)];
    for (i, robot) in world.robots().enumerate() {
        let own = &mut robots[i % PLACES];
        for (field, digest) in fields.iter_mut().zip(of_robot(&robot)) {
            field.add(digest);
            own.add(digest);
        }
    }
    let things = &mut fields[FIELDS.len() - 1];
    for thing in world.things() {
        things.add(numbers([thing.pose.position.x, thing.pose.position.y, thing.pose.heading]));
    }
    (fields.map(|field| field.digest()), robots.iter().map(|robot| robot.digest()).collect())
}

/// The digests of all fields but the last.
fn of_robot(robot: &RobotView<'_>) -> [u64; FIELDS.len() - 1] {
    let motion = robot.motion();
    let pose = numbers([motion.pose.position.x, motion.pose.position.y, motion.pose.heading]);
    let wheels = [motion.wheel_speed_rad_s, robot.signals()];
    let [speeds, signals] = wheels.map(|wheels| [wheels.left, wheels.right]);
    let speed = numbers([motion.speed_m_s, motion.turn_rate_rad_s].into_iter().chain(speeds));
    let mut samples = Mixer::default();
    for sensor in robot.sensors() {
        samples.add(sensor.samples);
        sensor.sample.iter().take(VALUES).for_each(|value| samples.add(value.to_bits()));
    }
    let mut readings = Mixer::default();
    for reading in robot.readings() {
        readings.add(u64::from(reading.sequence));
        reading.values.iter().take(VALUES).for_each(|value| readings.add(value.to_bits()));
    }
    let mut cable = Mixer::default();
    let (up, down) = (robot.uplink(), robot.downlink());
    let counts =
        [up.bytes, up.messages, up.bad_frames, up.lost(), down.messages, down.bad_frames, robot.commands()];
    counts.into_iter().for_each(|count| cable.add(count));
    let battery = robot.battery().map_or(0, |(battery, state)| state.share(battery).to_bits());
    let actuators = robot.actuators().iter().flat_map(|actuator| [actuator.signal, actuator.angle_rad]);
    [pose, speed, numbers(signals), samples.0, readings.0, cable.0, battery, numbers(actuators)]
}

/// The number of values of a scan that stand for the others.
const VALUES: usize = 8;

fn numbers(values: impl IntoIterator<Item = f64>) -> u64 {
    let mut mixer = Mixer::default();
    values.into_iter().for_each(|value| mixer.add(value.to_bits()));
    mixer.0
}

/// Mixes numbers into one: quickly, and without any claim but that other numbers hardly give the same.
#[derive(Clone, Copy, Debug, Default)]
struct Mixer(u64);

impl Mixer {
    fn add(&mut self, value: u64) {
        self.0 = (self.0.rotate_left(26) ^ value).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }

    fn digest(self) -> u16 {
        (self.0 >> 48) as u16
    }
}

//! The messages: their names and definitions in ROS 2, and their making.

use baudbot_sim::Pose;
use baudbot_sim::sensor::SensorKind;

use super::cdr::Cdr;
use super::covariance::{CERTAIN, Planar};

/// A kind of message: its name, and its definition with those that it needs, as MCAP wants it (`ros2msg`).
pub(super) struct Kind {
    pub(super) name: &'static str,
    pub(super) definition: &'static [&'static str],
}

const TIME: &str = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const HEADER: &str = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
const VECTOR: &str = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";
const POINT: &str = "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n";
const QUATERNION: &str = "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";
const POSE: &str =
    "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n";
const TWIST_PART: &str =
    "MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n";
const POSE_COVARIANCE: &str =
    "MSG: geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n";
const TWIST_COVARIANCE: &str =
    "MSG: geometry_msgs/TwistWithCovariance\ngeometry_msgs/Twist twist\nfloat64[36] covariance\n";
const TRANSFORM: &str =
    "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n";
const TRANSFORM_STAMPED: &str = "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n\
    geometry_msgs/Transform transform\n";

pub(super) const CLOCK: Kind =
    Kind { name: "rosgraph_msgs/msg/Clock", definition: &["builtin_interfaces/Time clock\n", TIME] };
pub(super) const TWIST: Kind = Kind {
    name: "geometry_msgs/msg/Twist",
    definition: &["geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n", VECTOR],
};
pub(super) const LASER_SCAN: Kind = Kind {
    name: "sensor_msgs/msg/LaserScan",
    definition: &[
        "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\nfloat32 time_increment\n\
         float32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\nfloat32[] intensities\n",
        HEADER,
        TIME,
    ],
};
pub(super) const RANGE: Kind = Kind {
    name: "sensor_msgs/msg/Range",
    definition: &[
        "std_msgs/Header header\nuint8 ULTRASOUND=0\nuint8 INFRARED=1\nuint8 radiation_type\nfloat32 field_of_view\n\
         float32 min_range\nfloat32 max_range\nfloat32 range\n",
        HEADER,
        TIME,
    ],
};
pub(super) const IMU: Kind = Kind {
    name: "sensor_msgs/msg/Imu",
    definition: &[
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
         geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
         geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
        HEADER,
        TIME,
        QUATERNION,
        VECTOR,
    ],
};
pub(super) const ODOMETRY: Kind = Kind {
    name: "nav_msgs/msg/Odometry",
    definition: &[
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
         geometry_msgs/TwistWithCovariance twist\n",
        HEADER,
        TIME,
        POSE_COVARIANCE,
        POSE,
        POINT,
        QUATERNION,
        TWIST_COVARIANCE,
        TWIST_PART,
        VECTOR,
    ],
};
pub(super) const TF: Kind = Kind {
    name: "tf2_msgs/msg/TFMessage",
    definition: &[
        "geometry_msgs/TransformStamped[] transforms\n",
        TRANSFORM_STAMPED,
        HEADER,
        TIME,
        TRANSFORM,
        VECTOR,
        QUATERNION,
    ],
};

/// The instant at which a message was true, and its frame.
#[derive(Clone, Copy)]
pub(super) struct Stamp<'a> {
    pub(super) ns: u64,
    pub(super) frame: &'a str,
}

/// The echoes of a laser.
pub(super) struct Scan<'a> {
    /// The angles of the first ray, and of the last.
    pub(super) ends_rad: [f64; 2],
    /// The time from the first ray to the last; 0 if all were at once.
    pub(super) sweep_s: f64,
    /// The time between two scans; 0 if that is not known.
    pub(super) period_s: f64,
    pub(super) range_m: [f64; 2],
    /// Negative where nothing was in range.
    pub(super) distances_m: &'a [f64],
    /// Whether the last ray stands where the first does.
    pub(super) ends_meet: bool,
}

/// The radiation of a sensor of one distance.
#[derive(Clone, Copy, Debug)]
pub(super) enum Radiation {
    Ultrasound,
    Infrared,
}

/// The reading of a sensor of one distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct RangeReading {
    pub(super) radiation: Radiation,
    pub(super) field_of_view_rad: f64,
    /// The least distance and the most.
    pub(super) range_m: [f64; 2],
    /// Endless where nothing was in range.
    pub(super) distance_m: f64,
}

/// A value with its variance.
pub(super) type Measured = (f64, f64);

/// The measurements of inertial sensors; `None` without such a sensor.
#[derive(Clone, Copy, Default)]
pub(super) struct Inertia {
    pub(super) heading_rad: Option<Measured>,
    pub(super) turn_rate_rad_s: Option<Measured>,
    /// The acceleration forwards and to the left, in m/s².
    pub(super) acceleration_m_s2: Option<[Measured; 2]>,
}

impl Inertia {
    /// Takes a reading, if it is of such a sensor.
    pub(super) fn take(&mut self, kind: SensorKind, values: &[Measured]) -> bool {
        match (kind, values) {
            (SensorKind::Compass, &[heading_rad]) => self.heading_rad = Some(heading_rad),
            (SensorKind::Gyroscope, &[turn_rate_rad_s]) => self.turn_rate_rad_s = Some(turn_rate_rad_s),
            (SensorKind::Accelerometer, &[forwards, left]) => self.acceleration_m_s2 = Some([forwards, left]),
            (_, _) => return false,
        }
        true
    }
}

fn header(Stamp { ns, frame }: Stamp<'_>) -> Cdr {
    Cdr::new().time(ns).text(frame)
}

/// A turn about the axis that points up.
fn quaternion(heading_rad: f64) -> [f64; 4] {
    let (sin, cos) = (0.5 * heading_rad).sin_cos();
    [0.0, 0.0, sin, cos]
}

pub(super) fn clock(ns: u64) -> Vec<u8> {
    Cdr::new().time(ns).bytes()
}

pub(super) fn twist([speed_m_s, turn_rate_rad_s]: [f64; 2]) -> Vec<u8> {
    Cdr::new().f64s(&[speed_m_s, 0.0, 0.0, 0.0, 0.0, turn_rate_rad_s]).bytes()
}

/// A ray that met nothing is endless, as the enhancement proposal 117 of ROS wants it. One that stands twice is left out: of a full turn
/// slam_toolbox expects as many readings as there are gaps, and drops a scan that has one more.
pub(super) fn laser_scan(stamp: Stamp<'_>, scan: &Scan<'_>) -> Vec<u8> {
    let gaps = scan.distances_m.len().saturating_sub(1).max(1) as f64;
    let [first, last] = scan.ends_rad;
    let gap = (last - first) / gaps;
    let mut distances_m = scan.distances_m;
    let mut last = last;
    if scan.ends_meet
        && let Some((_, others)) = distances_m.split_last()
    {
        distances_m = others;
        last -= gap;
    }
    let numbers = [first, last, gap, scan.sweep_s / gaps, scan.period_s];
    let cdr = numbers.into_iter().chain(scan.range_m).fold(header(stamp), Cdr::f32);
    let endless = |&distance_m: &f64| if distance_m < 0.0 { f64::INFINITY } else { distance_m };
    let cdr = distances_m.iter().map(endless).fold(cdr.length(distances_m.len()), Cdr::f32);
    cdr.length(0).bytes()
}

pub(super) fn range(stamp: Stamp<'_>, reading: &RangeReading) -> Vec<u8> {
    let radiation = match reading.radiation {
        Radiation::Ultrasound => 0,
        Radiation::Infrared => 1,
    };
    let [least_m, most_m] = reading.range_m;
    let numbers = [reading.field_of_view_rad, least_m, most_m, reading.distance_m];
    numbers.into_iter().fold(header(stamp).u8(radiation), Cdr::f32).bytes()
}

/// A quantity that is not measured has -1 in the first place of its covariances. The axes that lie in the floor do
/// not turn, and nothing falls: that is as good as certain.
pub(super) fn imu(stamp: Stamp<'_>, inertia: Inertia) -> Vec<u8> {
    let covariance = |variances: Option<[f64; 3]>| {
        let Some([x, y, z]) = variances else { return [-1.0, 0., 0., 0., 0., 0., 0., 0., 0.] };
        [x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z]
    };
    let about_up = |measured: Option<Measured>| measured.map(|(_, variance)| [CERTAIN, CERTAIN, variance]);
    let along = inertia.acceleration_m_s2.map(|[(_, forwards), (_, left)]| [forwards, left, CERTAIN]);
    let [(forwards, _), (left, _)] = inertia.acceleration_m_s2.unwrap_or_default();
    header(stamp)
        .f64s(&quaternion(inertia.heading_rad.unwrap_or_default().0))
        .f64s(&covariance(about_up(inertia.heading_rad)))
        .f64s(&[0.0, 0.0, inertia.turn_rate_rad_s.unwrap_or_default().0])
        .f64s(&covariance(about_up(inertia.turn_rate_rad_s)))
        .f64s(&[forwards, left, 0.0])
        .f64s(&covariance(along))
        .bytes()
}

/// A pose and the speeds of a robot.
pub(super) struct Moving {
    pub(super) pose: Pose,
    pub(super) pose_covariance: Planar,
    /// The speed forwards, and the turn rate.
    pub(super) speeds: [f64; 2],
    pub(super) speed_covariance: Planar,
}

pub(super) fn odometry(stamp: Stamp<'_>, child: &str, moving: &Moving) -> Vec<u8> {
    let Moving { pose, pose_covariance, speeds: [speed, turn_rate], speed_covariance } = moving;
    header(stamp)
        .text(child)
        .f64s(&[pose.position.x, pose.position.y, 0.0])
        .f64s(&quaternion(pose.heading))
        .f64s(&pose_covariance.in_space())
        .f64s(&[*speed, 0.0, 0.0, 0.0, 0.0, *turn_rate])
        .f64s(&speed_covariance.in_space())
        .bytes()
}

/// Transforms at one instant: parent, child, and parent from child.
pub(super) fn transforms(ns: u64, all: &[(&str, &str, Pose)]) -> Vec<u8> {
    let one = |cdr: Cdr, (parent, child, pose): &(&str, &str, Pose)| {
        cdr.time(ns)
            .text(parent)
            .text(child)
            .f64s(&[pose.position.x, pose.position.y, 0.0])
            .f64s(&quaternion(pose.heading))
    };
    all.iter().fold(Cdr::new().length(all.len()), one).bytes()
}

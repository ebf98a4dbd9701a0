"""Reads bags of ROS 2 that `baudbot export --rosbag2` makes, with the reader of others, and compares them with the table of the same run.

    python3 xtask/tools/check_rosbag.py BAUDBOT

Bags are of three runs, among which are a laser, an odometer, inertial sensors, motors that are told speeds, and several robots. The types are those of
ROS 2 Humble as `rosbags` knows them, and not the definitions in the bag; these must mean the same.
"""

import csv
import math
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

ROOT = Path(__file__).resolve().parents[2]
STORE = get_typestore(Stores.ROS2_HUMBLE)


def main(program):
    with tempfile.TemporaryDirectory() as place:
        place = Path(place)
        scans(*bag(program, place / "hall", "hall", "--brain", "hall"))
        inertia(*bag(program, place / "inertial", ROOT / "catalogue/scenarios/devices/inertial.toml", "--brain", "constant:left=0.3,right=0.2"))
        speeds(*bag(program, place / "stepper", ROOT / "catalogue/scenarios/devices/stepper.toml", "--brain", "constant:left=0.3,right=0.2"))
        several(*bag(program, place / "crowd", "ecoli", "--brain", "ecoli"))


def bag(program, folder, scenario, *brain):
    """The messages of a bag, by topic, and the rows of the table."""
    recording, table = folder.with_suffix(".mcap"), folder.with_suffix(".csv")
    run = [program, "run", scenario, *brain, "--seconds", "4", "--quiet", "--set", "collision=stop-robot", "--record", recording]
    subprocess.run(run, check=True, stdout=subprocess.DEVNULL)
    subprocess.run([program, "export", recording, "--rosbag2", folder, "--csv", table, "--quiet"], check=True)
    again = subprocess.run([program, "export", recording, "--rosbag2", folder, "--quiet"], capture_output=True, text=True)
    assert again.returncode != 0 and "is there already" in again.stderr, again
    messages = defaultdict(list)
    with AnyReader([folder], default_typestore=STORE) as reader:
        for connection in reader.connections:
            told = get_types_from_msg(connection.msgdef.data, connection.msgtype)
            for name, fields in told.items():
                assert STORE.fielddefs[name][1] == fields[1], f"{name} is another message in ROS"
        for connection in reader.connections:
            offered = connection.ext.offered_qos_profiles
            assert [profile.durability.name for profile in offered] == ["TRANSIENT_LOCAL" if connection.topic == "/tf_static" else "VOLATILE"], offered
        before = 0
        for connection, at_ns, data in reader.messages():
            assert at_ns >= before, "messages are in the order of time"
            before = at_ns
            messages[connection.topic].append((at_ns, STORE.deserialize_cdr(data, connection.msgtype)))
        for connection in reader.connections:
            assert connection.msgcount == len(messages[connection.topic]), connection.topic
    rows = list(csv.DictReader(table.open()))
    told = sorted(messages.items())[:12]
    print(f"{folder.name}: {len(messages)} topics: " + ", ".join(f"{topic} {len(said)}" for topic, said in told))
    clock(messages, rows)
    return messages, rows


def stamp_ns(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def heading(quaternion):
    return 2 * math.atan2(quaternion.z, quaternion.w)


def same(one, other, within=1e-12):
    assert abs(math.remainder(one - other, math.tau)) < within or abs(one - other) < within, (one, other)


def clock(messages, rows):
    """The clock and the frames have the truth of each tick."""
    instants = sorted({round(float(row["t_s"]) * 1e9) for row in rows})
    told = [message.clock.sec * 10**9 + message.clock.nanosec for _, message in messages["/clock"]]
    assert told == instants == [at_ns for at_ns, _ in messages["/clock"]]


def truth(messages, rows, prefix=""):
    """The true pose, twice: as such, and as the product of the frames."""
    said = messages[f"/{prefix}ground_truth"]
    assert len(said) == len(rows)
    frames = {}
    for _, message in messages["/tf"]:
        for transform in message.transforms:
            at_ns = transform.header.stamp.sec * 10**9 + transform.header.stamp.nanosec
            frames[(at_ns, transform.header.frame_id, transform.child_frame_id)] = transform.transform
    for (at_ns, message), row in zip(said, rows, strict=True):
        pose, twist = message.pose.pose, message.twist.twist
        same(pose.position.x, float(row["x_m"]))
        same(pose.position.y, float(row["y_m"]))
        same(heading(pose.orientation), float(row["heading_rad"]))
        same(twist.linear.x, float(row["speed_m_s"]))
        first = frames[(at_ns, "map", f"{prefix}odom")]
        second = frames[(at_ns, f"{prefix}odom", f"{prefix}base_link")]
        turn = heading(first.rotation)
        x, y = second.translation.x, second.translation.y
        same(first.translation.x + math.cos(turn) * x - math.sin(turn) * y, float(row["x_m"]), 1e-9)
        same(first.translation.y + math.sin(turn) * x + math.cos(turn) * y, float(row["y_m"]), 1e-9)


def scans(messages, rows):
    truth(messages, rows)
    said = messages["/scan"]
    assert len(said) > 10
    columns = [column for column in rows[0] if column.startswith("laser")]
    by_values = {}
    for row in rows:
        by_values.setdefault(row[columns[0]] + row[columns[-1]], row)
    frames = {transform.child_frame_id for _, message in messages["/tf_static"] for transform in message.transforms}
    for at_ns, scan in said:
        assert len(scan.ranges) == len(columns) and scan.header.frame_id in frames
        assert stamp_ns(scan) <= at_ns
        row = next(row for row in rows if round(float(row["t_s"]) * 1e9) == at_ns)
        for distance, column in zip(scan.ranges, columns, strict=True):
            if float(row[column]) < 0:
                assert math.isinf(distance)
            else:
                assert abs(distance - float(row[column])) < 1e-6, (distance, row[column])
        span = scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)
        assert abs(span - scan.angle_max) < 1e-4
    odometry = messages["/odom"]
    assert odometry, "this robot has an odometer"
    for at_ns, message in odometry:
        row = next(row for row in rows if round(float(row["t_s"]) * 1e9) == at_ns)
        position = message.pose.pose.position
        same(position.x, float(row["odometer.x"] if "odometer.x" in row else row["odometer.x_m"]))
        assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")


def inertia(messages, rows):
    truth(messages, rows)
    assert len(messages["/imu"]) > 10
    known = [message for _, message in messages["/imu"]][-1]
    assert known.angular_velocity_covariance[8] > 0 or known.linear_acceleration_covariance[0] > 0
    assert known.orientation_covariance[0] == -1, "this robot has no compass"


def speeds(messages, rows):
    truth(messages, rows)
    commands = [message for _, message in messages["/cmd_vel"]]
    assert commands[0].linear.x == 0
    assert commands[-1].linear.x > 0 and commands[-1].angular.z < 0, "to the right"


def several(messages, rows):
    names = sorted({row["robot"] for row in rows})
    assert len(names) > 1
    for name in names[:3]:
        prefix = "".join(c if c.isalnum() else "_" for c in name) + "/"
        truth(messages, [row for row in rows if row["robot"] == name], prefix)


if __name__ == "__main__":
    main(sys.argv[1])

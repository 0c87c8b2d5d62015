#!/usr/bin/env python3
"""Writes the logs beside it, by writers that are not ours.

    gmr simulate --rate 20 --sensors servo --mass 1@0,6@30 --seed 7 --duration 60 --out drive.csv
    pip install rosbags==0.11.9 pyarrow==26.0.1 pyulog==1.3.0
    python make.py

drive.*       the same drive in every format: wheel speeds, power and total mass as messages of their own, all stamped alike
turtlebot3    what turtlebot3_node publishes: stamps 20 ms before the receipt, odometry and battery at other rates, a battery whose current
              is never set, commands without a stamp; chunks in zstd
clearpath     four wheels under a namespace, a BatteryState with current, as docs.clearpathrobotics.com lists them (Jazzy)
husarion      fl_wheel_joint ..., /battery/battery_status, in SQLite of rosbag2 version 8, which carries no definitions
odometry      no joint states: odometry and power only
compressed    a bag whose messages are compressed one by one
"""

import csv
import pathlib
import shutil
import struct
import tempfile

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pyulog
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

HERE = pathlib.Path(__file__).parent
TYPES = get_typestore(Stores.ROS2_JAZZY)
START = 1_760_000_000_000_000_000
T = TYPES.types


def header(ns):
    return T["std_msgs/msg/Header"](T["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9), "")


def joints(ns, names, speeds):
    speeds = np.array(speeds)
    return "sensor_msgs/msg/JointState", T["sensor_msgs/msg/JointState"](header(ns), names, speeds * 0, speeds, speeds * 0)


def battery(ns, volts, amps, share):
    none = np.array([], dtype=np.float32)
    state = T["sensor_msgs/msg/BatteryState"]
    nan = float("nan")
    return "sensor_msgs/msg/BatteryState", state(header(ns), volts, nan, amps, nan, nan, 1.8, share, 2, 1, 2, True, none, none, "", "")


def twist(v, w):
    vector = T["geometry_msgs/msg/Vector3"]
    return T["geometry_msgs/msg/Twist"](vector(v, 0.0, 0.0), vector(0.0, 0.0, w))


def odometry(ns, v, w):
    pose = T["geometry_msgs/msg/Pose"](T["geometry_msgs/msg/Point"](0.0, 0.0, 0.0), T["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0))
    zeros = np.zeros(36)
    message = T["nav_msgs/msg/Odometry"](
        header(ns), "base", T["geometry_msgs/msg/PoseWithCovariance"](pose, zeros),
        T["geometry_msgs/msg/TwistWithCovariance"](twist(v, w), zeros))
    return "nav_msgs/msg/Odometry", message


def number(value):
    return "std_msgs/msg/Float64", T["std_msgs/msg/Float64"](value)


def bag(name, plugin, messages, version=9, compressed=None):
    """messages: (received, topic, (type, message)), in any order"""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "bag"
        writer = Writer(path, version=version, storage_plugin=plugin)
        if compressed:
            writer.set_compression(compressed, CompressionFormat.ZSTD)
        with writer:
            connections = {}
            for received, topic, (kind, message) in sorted(messages, key=lambda m: m[0]):
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=TYPES)
                writer.write(connections[topic], received, TYPES.serialize_cdr(message, kind))
        [made] = [file for file in path.iterdir() if file.suffix in (".mcap", ".db3")]
        shutil.copy(made, HERE / name)


def ulog(name, rows):
    """The right wheel is the first, as in PX4's Roboclaw driver. By docs.px4.io/main/en/dev_log/ulog_file_format.html; read back with pyulog."""
    def record(kind, body):
        return struct.pack("<HB", len(body), ord(kind)) + body
    formats = {
        "wheel_encoders": ("uint64_t timestamp;double[2] wheel_speed;", lambda r: struct.pack("<dd", r[2], r[1])),
        "drive_power": ("uint64_t timestamp;double power_w;", lambda r: struct.pack("<d", r[3])),
        "payload": ("uint64_t timestamp;double mass_kg;", lambda r: struct.pack("<d", r[4])),
    }
    data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + record("B", bytes(40))
    for message, (fields, _) in formats.items():
        data += record("F", f"{message}:{fields}".encode())
    for number, message in enumerate(formats):
        data += record("A", struct.pack("<BH", 0, number) + message.encode())
    for row in rows:
        for number, (_, pack) in enumerate(formats.values()):
            data += record("D", struct.pack("<HQ", number, 1_000_000 + round(row[0] * 1e6)) + pack(row))
    (HERE / name).write_bytes(data)
    read = pyulog.ULog(str(HERE / name))
    assert {d.name: len(d.data["timestamp"]) for d in read.data_list} == dict.fromkeys(formats, len(rows))


def main():
    with open(HERE / "drive.csv") as file:
        reader = csv.reader(file)
        names = next(reader)
        rows = [[float(field) for field in row] for row in reader]
    assert names == ["time_s", "wheel1_rad_s", "wheel2_rad_s", "power_w", "mass_kg"], names
    ns = [START + round(row[0] * 1e9) for row in rows]

    pair = ["wheel_left_joint", "wheel_right_joint"]
    same = []
    for t, (_, left, right, power, mass) in zip(ns, rows):
        same += [(t, "/joint_states", joints(t, pair, [left, right])), (t, "/power", number(power)), (t, "/total_mass", number(mass))]
    bag("drive.mcap", StoragePlugin.MCAP, same, compressed=CompressionMode.STORAGE)
    bag("drive.db3", StoragePlugin.SQLITE3, same)
    ulog("drive.ulg", rows)
    table = pa.table({name: [row[place] for row in rows] for place, name in enumerate(names)})
    pq.write_table(table, HERE / "drive.parquet", compression="zstd", row_group_size=500)

    rows, ns = rows[:400], ns[:400]
    turtle, clear, husarion, odom = [], [], [], []
    four = [f"{end}_{side}_wheel_joint" for end in ("front", "rear") for side in ("left", "right")]
    short = ["fl_wheel_joint", "fr_wheel_joint", "rl_wheel_joint", "rr_wheel_joint"]
    for place, (t, (_, left, right, power, mass)) in enumerate(zip(ns, rows)):
        v, w = 0.033 * (left + right) / 2, 0.033 * (right - left) / 0.16
        late = t + 20_000_000
        turtle.append((late, "/joint_states", joints(t, pair, [left, right])))
        clear.append((late, "/a200_0000/platform/joint_states", joints(t, four, [left, right, left, right])))
        husarion.append((late, "/joint_states", joints(t, short, [left, right, left, right])))
        # Another publisher of joints, as a manipulator's.
        husarion.append((late + 1, "/joint_states", joints(t + 1, ["arm_joint"], [0.1])))
        odom.append((late, "/odom", odometry(t, v, w)))
        odom.append((late, "/power", number(power)))
        if place % 2 == 0:
            turtle.append((late, "/odom", odometry(t, v, w)))
            turtle.append((late, "/cmd_vel", ("geometry_msgs/msg/Twist", twist(v, w))))
            stamped = T["geometry_msgs/msg/TwistStamped"](header(t), twist(v, w))
            clear.append((late, "/a200_0000/platform/cmd_vel", ("geometry_msgs/msg/TwistStamped", stamped)))
        if place % 4 == 0:
            share = 0.9 - 1e-4 * place
            turtle.append((late, "/battery_state", battery(t, 12.0, 0.0, share)))
            clear.append((late, "/a200_0000/platform/bms/state", battery(t, 24.0, -power / 24.0, share)))
            husarion.append((late, "/battery/battery_status", battery(t, 12.0, -power / 12.0, share)))
    bag("turtlebot3.mcap", StoragePlugin.MCAP, turtle, compressed=CompressionMode.STORAGE)
    bag("clearpath.mcap", StoragePlugin.MCAP, clear)
    bag("husarion.db3", StoragePlugin.SQLITE3, husarion, version=8)
    bag("odometry.mcap", StoragePlugin.MCAP, odom, compressed=CompressionMode.STORAGE)
    bag("compressed.db3", StoragePlugin.SQLITE3, odom[:20], compressed=CompressionMode.MESSAGE)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Writes the bags beside it with rosbags, a program that is not ours: a simulated TurtleBot3, weighed before each drive.

    pip install rosbags==0.11.9
    python make.py

empty, full   ten seconds of standing and a drive of a minute at 1.00 and 6.00 kg, as turtlebot3_node names its topics: /joint_states and /battery_state at 50 Hz. The
              battery's current is measured, and negative while it discharges: voltage times current is the robot's total power, 6.4 W of it
              for its computer and lidar. The mass is in no topic, as in every bag: gmr takes it behind the name
positive      half a minute at 1 kg, of a driver that counts a discharging current as positive; its battery is called /bat
two           the same with the wheels' joints in two topics, of two robots
"""

import csv
import pathlib
import subprocess
import tempfile

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

HERE = pathlib.Path(__file__).parent
TYPES = get_typestore(Stores.ROS2_JAZZY)
T = TYPES.types
START = 1_780_000_000_000_000_000
JOINTS = ["wheel_left_joint", "wheel_right_joint"]
# A charged pack of three cells, and what it holds, Ah.
VOLTS, CAPACITY = 12.1, 1.8
STANDING_S = 10


def header(ns):
    return T["std_msgs/msg/Header"](T["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9), "")


def joints(ns, speeds):
    speeds = np.array(speeds)
    return "sensor_msgs/msg/JointState", T["sensor_msgs/msg/JointState"](header(ns), JOINTS, speeds * 0, speeds, speeds * 0)


def battery(ns, amps, share):
    none, nan = np.array([], dtype=np.float32), float("nan")
    state = T["sensor_msgs/msg/BatteryState"]
    return "sensor_msgs/msg/BatteryState", state(header(ns), VOLTS, nan, amps, nan, nan, CAPACITY, share, 2, 1, 2, True, none, none, "", "")


def simulate(mass, seed, duration, profile):
    """Rows of the simulated robot: time, both wheels' speeds, total power."""
    with tempfile.TemporaryDirectory() as folder:
        log = pathlib.Path(folder) / "drive.csv"
        command = ["gmr", "simulate", "--sensors", "servo", "--rate", "50", "--static-power", "6.4", "--no-mass", "--profile", profile]
        command += ["--mass", str(mass), "--seed", str(seed), "--duration", str(duration), "--out", str(log)]
        subprocess.run(command, check=True)
        with open(log) as rows:
            return [[float(field) for field in row] for row in list(csv.reader(rows))[1:]]


def drive(mass, seed, duration):
    """Ten seconds of standing, as whoever wants to know the static power records, and then a drive."""
    standing = simulate(mass, seed, STANDING_S, "standstill")[:-1]
    driving = simulate(mass, seed, duration - STANDING_S, "training")
    return standing + [[time + STANDING_S, *rest] for time, *rest in driving]


def write(name, rows, topics=("/joint_states",), bat="/battery_state", sign=-1.0):
    with tempfile.TemporaryDirectory() as folder:
        bag = pathlib.Path(folder) / "bag"
        writer = Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP)
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with writer:
            connections = {}
            drawn, last = 0.0, rows[0][0]
            for time, left, right, power in rows:
                ns = START + int(time * 1e9)
                amps = power / VOLTS
                drawn += amps * (time - last) / 3600.0
                last = time
                messages = [(topic, joints(ns, [left, right])) for topic in topics]
                messages.append((bat, battery(ns, sign * amps, 0.9 - drawn / CAPACITY)))
                for topic, (kind, message) in messages:
                    if topic not in connections:
                        connections[topic] = writer.add_connection(topic, kind, typestore=TYPES)
                    writer.write(connections[topic], ns + 2_000_000, TYPES.serialize_cdr(message, kind))
        (bag / "bag.mcap").replace(HERE / name)


write("empty.mcap", drive(1.0, 41, 70))
write("full.mcap", drive(6.0, 42, 70))
write("positive.mcap", drive(1.0, 43, 30), bat="/bat", sign=1.0)
write("two.mcap", drive(1.0, 43, 15), topics=("/joint_states", "/other/joint_states"))

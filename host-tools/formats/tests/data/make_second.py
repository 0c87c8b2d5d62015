#!/usr/bin/env python3
"""Writes second.mcap: the drive of drive.csv by a second writer that is not ours, that of MCAP's makers.

    pip install mcap==1.6.0 mcap-ros2-support==0.6.0
    python make_second.py

As recorders other than rosbag2 write: many small chunks in LZ4, definitions as they stand in ROS's packages, messages of topics that lie among
each other out of order, and each received 3 ms after it was published.
"""

import csv
import pathlib

from mcap.writer import CompressionType
from mcap_ros2.writer import Writer

HERE = pathlib.Path(__file__).parent
START = 1_760_000_000_000_000_000
BORDER = "=" * 80

JOINT_STATE = f"""std_msgs/Header header

string[] name  # of each joint
float64[] position
float64[] velocity
float64[] effort
{BORDER}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{BORDER}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def main():
    with open(HERE / "drive.csv") as file:
        reader = csv.reader(file)
        assert next(reader) == ["time_s", "wheel1_rad_s", "wheel2_rad_s", "power_w", "mass_kg"]
        rows = [[float(field) for field in row] for row in reader]
    with open(HERE / "second.mcap", "wb") as file:
        writer = Writer(file, chunk_size=16 << 10, compression=CompressionType.LZ4)
        joints = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        number = writer.register_msgdef("std_msgs/msg/Float64", "float64 data\n")
        for place, (time, left, right, power, mass) in enumerate(rows):
            at = START + round(time * 1e9)
            stamp = {"sec": at // 10**9, "nanosec": at % 10**9}
            wheels = {
                "header": {"stamp": stamp, "frame_id": "base"},
                "name": ["wheel_left_joint", "wheel_right_joint"],
                "position": [0.0, 0.0], "velocity": [left, right], "effort": [],
            }
            messages = [("/power", number, {"data": power}), ("/total_mass", number, {"data": mass}), ("/joint_states", joints, wheels)]
            for topic, schema, message in messages if place % 2 else reversed(messages):
                # Topics without a stamp go by the receipt, which is that of the drive.
                received = at if schema is number else at + 3_000_000
                writer.write_message(topic, schema, message, log_time=received, publish_time=at, sequence=place)
        writer.finish()


if __name__ == "__main__":
    main()

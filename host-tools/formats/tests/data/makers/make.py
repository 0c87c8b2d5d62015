#!/usr/bin/env python3
"""Writes the logs beside it as the makers' own robots and tools leave them, by writers that are not ours.

    pip install rosbags==0.11.9 pymavlink==2.4.50
    python make.py

Each holds every second row of ../drive.csv, which is drive.csv here: wheel speeds, power and total mass.

turtlebot4    Create 3: wheel_vels, wheel_status, battery_state whose current is negative while discharging, odom at another rate
odrive        two ODrives by CAN: bus voltage and current, revolutions of the motor a second; the right one is mounted the other way round
vesc          two VESCs: input voltage and current, electrical revolutions a minute
clearpath     a Husky A200: joints of four wheels, power of both drivers and of all else
jackal        a Jackal: the same topics, four currents, the first of which is the total
lynx          motor feedback of four wheels, and no other power
husarion      a Panther: two motor drivers, front and rear
level         the first 80 rows on a slope of 0.05 rad, nose up, turning about: /tf, among the transforms of the wheels
planar        the same as odometry sees it that knows the plane only
ros1-*.bag    the same drive as ROS 1 records it, in chunks as they are, by lz4 and by bz2
rover.bin     DataFlash of ArduPilot, by its documented format; read back with pymavlink
vesc-tool.csv what VESC Tool logs of one VESC

Definitions as the makers have them, without their comments: odriverobotics/ros_odrive, f1tenth/vesc, clearpathrobotics/clearpath_msgs,
husarion/husarion_ugv_ros, iRobotEducation/irobot_create_msgs.
"""

import csv
import math
import pathlib
import shutil
import struct
import tempfile

import numpy as np
from pymavlink import DFReader
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

HERE = pathlib.Path(__file__).parent
START = 1_760_000_000_000_000_000
RADIUS, TRACK = 0.033, 0.16

DEFINITIONS = {
    "odrive_can/msg/ODriveStatus":
        "float32 bus_voltage\nfloat32 bus_current\nfloat32 fet_temperature\nfloat32 motor_temperature\n"
        "uint32 active_errors\nuint32 disarm_reason\n",
    "odrive_can/msg/ControllerStatus":
        "float32 pos_estimate\nfloat32 vel_estimate\nfloat32 torque_target\nfloat32 torque_estimate\nfloat32 iq_setpoint\n"
        "float32 iq_measured\nuint32 active_errors\nuint8 axis_state\nuint8 procedure_result\nbool trajectory_done_flag\n",
    "vesc_msgs/msg/VescState":
        "int32 FAULT_CODE_NONE=0\nfloat64 temp_fet\nfloat64 temp_motor\nfloat64 current_motor\nfloat64 current_input\nfloat64 avg_id\n"
        "float64 avg_iq\nfloat64 duty_cycle\nfloat64 speed\nfloat64 voltage_input\nfloat64 charge_drawn\nfloat64 charge_regen\n"
        "float64 energy_drawn\nfloat64 energy_regen\nint32 displacement\nint32 distance_traveled\nint32 fault_code\n"
        "float64 pid_pos_now\nint32 controller_id\nfloat64 ntc_temp_mos1\nfloat64 ntc_temp_mos2\nfloat64 ntc_temp_mos3\n"
        "float64 avg_vd\nfloat64 avg_vq\n",
    "vesc_msgs/msg/VescStateStamped": "std_msgs/Header header\nvesc_msgs/VescState state\n",
    "clearpath_platform_msgs/msg/Power":
        "std_msgs/Header header\nint8 NOT_APPLICABLE=-1\nint8 shore_power_connected\nint8 battery_connected\n"
        "int8 power_12v_user_nominal\nint8 charger_connected\nint8 charging_complete\nfloat32[] measured_voltages\n"
        "float32[] measured_currents\n",
    "clearpath_motor_msgs/msg/LynxFeedback":
        "uint8 can_id\nstring joint_name\nfloat32 current\nfloat32 voltage\nfloat32 velocity\nfloat32 travel\n",
    "clearpath_motor_msgs/msg/LynxMultiFeedback": "std_msgs/Header header\nclearpath_motor_msgs/LynxFeedback[] drivers\n",
    "husarion_ugv_msgs/msg/DriverState":
        "float32 voltage\nfloat32 current\nfloat32 temperature\nfloat32 heatsink_temperature\nbool motor_states_data_timed_out\n"
        "bool driver_state_data_timed_out\nbool can_error\nbool heartbeat_timeout\n",
    "husarion_ugv_msgs/msg/DriverStateNamed": "string name\nhusarion_ugv_msgs/DriverState state\n",
    "husarion_ugv_msgs/msg/RobotDriverState":
        "std_msgs/Header header\nhusarion_ugv_msgs/DriverStateNamed[] driver_states\nbool error\nbool write_pdo_cmds_error\n"
        "bool read_pdo_motor_states_error\nbool read_pdo_driver_state_error\n",
    "irobot_create_msgs/msg/WheelVels": "std_msgs/Header header\nfloat32 velocity_left\nfloat32 velocity_right\n",
    "irobot_create_msgs/msg/WheelStatus":
        "std_msgs/Header header\nint16 current_ma_left\nint16 current_ma_right\nint16 pwm_left\nint16 pwm_right\nbool wheels_enabled\n",
}

TYPES = get_typestore(Stores.ROS2_JAZZY)
own = {}
for name, definition in DEFINITIONS.items():
    own.update(get_types_from_msg(definition, name))
TYPES.register(own)
T = TYPES.types


def header(ns):
    return T["std_msgs/msg/Header"](T["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9), "")


def message(kind, *values):
    return kind, T[kind](*values)


def joints(ns, names, speeds):
    speeds = np.array(speeds)
    return message("sensor_msgs/msg/JointState", header(ns), names, speeds * 0, speeds, speeds * 0)


def mass(value):
    return message("std_msgs/msg/Float64", value)


def odometry(ns, v, w):
    vector = T["geometry_msgs/msg/Vector3"]
    twist = T["geometry_msgs/msg/Twist"](vector(v, 0.0, 0.0), vector(0.0, 0.0, w))
    pose = T["geometry_msgs/msg/Pose"](T["geometry_msgs/msg/Point"](0.0, 0.0, 0.0), T["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0))
    zeros = np.zeros(36)
    return message(
        "nav_msgs/msg/Odometry", header(ns), "base", T["geometry_msgs/msg/PoseWithCovariance"](pose, zeros),
        T["geometry_msgs/msg/TwistWithCovariance"](twist, zeros))


def imu(ns, nose_up):
    vector, quaternion = T["geometry_msgs/msg/Vector3"], T["geometry_msgs/msg/Quaternion"]
    zeros = np.zeros(9)
    orientation = quaternion(0.0, math.sin(-nose_up / 2), 0.0, math.cos(nose_up / 2))
    gravity = vector(9.81 * math.sin(nose_up), 0.0, 9.81 * math.cos(nose_up))
    return message("sensor_msgs/msg/Imu", header(ns), orientation, zeros, vector(0.0, 0.0, 0.0), zeros, gravity, zeros)


def bag(name, messages):
    """messages: (received, topic, (type, message)), in any order"""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "bag"
        writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        with writer:
            connections = {}
            for received, topic, (kind, value) in sorted(messages, key=lambda m: m[0]):
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=TYPES)
                writer.write(connections[topic], received, TYPES.serialize_cdr(value, kind))
        [made] = path.glob("*.mcap")
        shutil.copy(made, HERE / name)


def tilted(name, rows, nose_up):
    """Turns at 2 rad/s: the quaternion of tf2's setRPY(0, -nose_up, yaw), which changes its sign at half a turn."""
    stamped, moved = T["geometry_msgs/msg/TransformStamped"], T["geometry_msgs/msg/Transform"]
    vector, quaternion = T["geometry_msgs/msg/Vector3"], T["geometry_msgs/msg/Quaternion"]
    head = lambda ns, frame: T["std_msgs/msg/Header"](T["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9), frame)
    transform = lambda ns, frame, child, turn: stamped(head(ns, frame), child, moved(vector(0.1, 0.0, 0.0), quaternion(*turn)))
    messages = []
    for place, (t, left, right, watts, kilograms) in enumerate(rows):
        messages.append((t, "/joint_states", joints(t, ["wheel_left_joint", "wheel_right_joint"], [left, right])))
        messages.append((t, "/power", mass(watts)))
        messages.append((t, "/total_mass", mass(kilograms)))
        # Between two rows, and received late, as over a network: their own stamps count.
        t += 50_000_000
        yaw = (2e-9 * (t - START) + math.pi) % math.tau - math.pi
        (s, c), (u, v) = (math.sin(-nose_up / 2), math.cos(nose_up / 2)), (math.sin(yaw / 2), math.cos(yaw / 2))
        body = transform(t, "odom", "base_link", (-u * s, v * s, u * c, v * c))
        wheel = lambda side: transform(t, "base_link", f"wheel_{side}_link", (0.0, math.sin(place), 0.0, math.cos(place)))
        tf = "tf2_msgs/msg/TFMessage"
        messages.append((t + 30_000_000, "/tf", message(tf, [wheel("left"), body])))
        messages.append((t + 31_000_000, "/tf", message(tf, [wheel("right")])))
    bag(name, messages)


def bag1(name, compression, rows):
    types = get_typestore(Stores.ROS1_NOETIC)
    own = types.types
    time, head = own["builtin_interfaces/msg/Time"], own["std_msgs/msg/Header"]
    path = HERE / name
    path.unlink(missing_ok=True)
    writer = Writer1(path)
    if compression:
        writer.set_compression(compression)
    with writer:
        state = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=types)
        power = writer.add_connection("/power", "std_msgs/msg/Float64", typestore=types)
        total = writer.add_connection("/total_mass", "std_msgs/msg/Float64", typestore=types)
        for place, (t, left, right, watts, kilograms) in enumerate(rows):
            names = ["wheel_left_joint", "wheel_right_joint"]
            speeds = np.array([left, right])
            stamp = time(t // 10**9, t % 10**9)
            value = own["sensor_msgs/msg/JointState"](head(place, stamp, ""), names, speeds * 0, speeds, speeds * 0)
            writer.write(state, t, types.serialize_ros1(value, "sensor_msgs/msg/JointState"))
            for connection, number in ((power, watts), (total, kilograms)):
                value = own["std_msgs/msg/Float64"](number)
                writer.write(connection, t, types.serialize_ros1(value, "std_msgs/msg/Float64"))


def dataflash(name, rows):
    """By ardupilot.org/dev/docs/code-overview-adding-a-new-log-message.html; read back with pymavlink's reader."""
    formats = {
        "FMT": (128, 89, "BBnNZ", "Type,Length,Name,Format,Columns"),
        "BAT": (1, None, "QBff", "TimeUS,Inst,Volt,Curr"),
        "ESC": (2, None, "QBf", "TimeUS,Instance,RPM"),
        "PLD": (3, None, "Qe", "TimeUS,Mass"),
    }
    sizes = {"Q": 8, "B": 1, "f": 4, "e": 4}
    data = b""
    for kind, (number, length, codes, labels) in formats.items():
        length = length or 3 + sum(sizes[code] for code in codes)
        data += b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", number, length, kind.encode(), codes.encode(), labels.encode())
    for t, left, right, watts, kilograms in rows:
        us = (t - START) // 1000 + 1_000_000
        for wheel, speed in enumerate((left, right)):
            data += b"\xa3\x95\x02" + struct.pack("<QBf", us, wheel, speed * 60 / math.tau)
        data += b"\xa3\x95\x01" + struct.pack("<QBff", us, 0, 12.5, watts / 12.5)
        # Hundredths, as the format has them.
        data += b"\xa3\x95\x03" + struct.pack("<Qi", us, round(kilograms * 100))
    path = HERE / name
    path.write_bytes(data)
    log = DFReader.DFReader_binary(str(path))
    volts = []
    while (found := log.recv_match(type="BAT")) is not None:
        volts.append(found.Volt * found.Curr)
    assert np.allclose(volts, [row[3] for row in rows], rtol=1e-6), "pymavlink reads what was written"


def vesc_tool(name, rows):
    """The columns that VESC Tool writes, a semicolon behind each."""
    columns = (
        "ms_today input_voltage temp_mos_max temp_mos_1 temp_mos_2 temp_mos_3 temp_motor current_motor current_in d_axis_current "
        "q_axis_current erpm duty_cycle amp_hours_used amp_hours_charged watt_hours_used watt_hours_charged tachometer "
        "tachometer_abs encoder_position fault_code vesc_id d_axis_voltage q_axis_voltage ms_today_setup amp_hours_setup "
        "amp_hours_charged_setup watt_hours_setup watt_hours_charged_setup battery_level battery_wh_tot current_in_setup "
        "current_motor_setup speed_meters_per_sec tacho_meters tacho_abs_meters num_vescs").split()
    lines = [";".join(columns) + ";"]
    for t, left, right, watts, _ in rows:
        # From before midnight to behind it.
        ms = (86_399_000 + (t - START) // 10**6) % 86_400_000
        values = dict.fromkeys(columns, 0)
        values |= {"ms_today": ms, "ms_today_setup": ms, "input_voltage": 12.5, "num_vescs": 2, "current_in": watts / 25}
        values |= {"current_in_setup": watts / 12.5, "erpm": 7 * 60 / math.tau * (left + right) / 2}
        lines.append(";".join(str(values[column]) for column in columns) + ";")
    (HERE / name).write_text("\n".join(lines) + "\n")


def main():
    with open(HERE.parent / "drive.csv") as file:
        reader = csv.reader(file)
        names = next(reader)
        rows = [[float(field) for field in row] for row in reader][::2]
    with open(HERE / "drive.csv", "w") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows(rows)
    rows = [(START + round(row[0] * 1e9), *row[1:]) for row in rows]

    logs = {name: [] for name in ("turtlebot4", "odrive", "vesc", "clearpath", "jackal", "lynx", "husarion")}
    four = [f"{end}_{side}_wheel_joint" for end in ("front", "rear") for side in ("left", "right")]
    short = ["fl_wheel_joint", "fr_wheel_joint", "rl_wheel_joint", "rr_wheel_joint"]
    none = np.array([], dtype=np.float32)
    floats = lambda *values: np.array(values, dtype=np.float32)
    for place, (t, left, right, watts, kilograms) in enumerate(rows):
        for log in logs.values():
            log.append((t, "/total_mass", mass(kilograms)))
        amps = watts / 12.5
        add = logs["turtlebot4"].append
        add((t, "/wheel_vels", message("irobot_create_msgs/msg/WheelVels", header(t), left, right)))
        current = [round(1000 * amps / 2)] * 2
        add((t, "/wheel_status", message("irobot_create_msgs/msg/WheelStatus", header(t), *current, 8000, 8000, True)))
        nan = float("nan")
        add((t, "/battery_state", message(
            "sensor_msgs/msg/BatteryState", header(t), 12.5, nan, -amps, nan, nan, 1.8, 0.9 - 1e-4 * place, 2, 1, 2, True, none, none, "", "")))
        if place % 3 == 0:
            add((t, "/odom", odometry(t, RADIUS * (left + right) / 2, RADIUS * (right - left) / TRACK)))
            add((t, "/imu", imu(t, 0.05)))
        for side, speed, share, sign in (("left", left, 0.375, 1), ("right", right, 0.625, -1)):
            add = logs["odrive"].append
            add((t, f"/{side}/odrive_status", message("odrive_can/msg/ODriveStatus", 12.5, share * amps, 30.0, 31.0, 0, 0)))
            revolutions = sign * speed / math.tau
            add((t, f"/{side}/controller_status", message(
                "odrive_can/msg/ControllerStatus", 0.0, revolutions, 0.0, 0.0, 0.0, 0.0, 0, 8, 0, True)))
            state = [30.0, 31.0, 1.0, share * amps, 0.0, 0.0, 0.1, 7 * speed * 60 / math.tau, 12.5, *[0.0] * 4, 0, 0, 0, 0.0, 1, *[0.0] * 5]
            logs["vesc"].append((t, f"/{side}/sensors/core", message(
                "vesc_msgs/msg/VescStateStamped", header(t), T["vesc_msgs/msg/VescState"](*state))))
        for name in ("clearpath", "jackal", "lynx"):
            logs[name].append((t, "/r_0000/platform/joint_states", joints(t, four, [left, right, left, right])))
        power = lambda volts, amperes: message("clearpath_platform_msgs/msg/Power", header(t), -1, 1, 1, 0, 0, volts, amperes)
        topic = "/r_0000/platform/mcu/status/power"
        logs["clearpath"].append((t, topic, power(floats(12.5, 12.5, 12.5), floats(0.25 * amps, 0.25 * amps, 0.5 * amps))))
        logs["jackal"].append((t, topic, power(floats(12.5, 5.0, 12.0), floats(amps, 0.1 * amps, 0.6 * amps, 0.3 * amps))))
        feedback = T["clearpath_motor_msgs/msg/LynxFeedback"]
        drivers = [feedback(at, joint, 0.25 * amps, 12.5, (left, right)[at % 2], 0.0) for at, joint in enumerate(four)]
        logs["lynx"].append((t, "/r_0000/platform/motors/feedback", message("clearpath_motor_msgs/msg/LynxMultiFeedback", header(t), drivers)))
        logs["husarion"].append((t, "/joint_states", joints(t, short, [left, right, left, right])))
        state = lambda share: T["husarion_ugv_msgs/msg/DriverState"](12.5, share * amps, 30.0, 31.0, False, False, False, False)
        ends = [T["husarion_ugv_msgs/msg/DriverStateNamed"](end, state(share)) for end, share in (("front", 0.375), ("rear", 0.625))]
        logs["husarion"].append((t, "/hardware/robot_driver_state", message(
            "husarion_ugv_msgs/msg/RobotDriverState", header(t), ends, False, False, False, False)))
    for name, messages in logs.items():
        bag(f"{name}.mcap", messages)
    for name, compression in (("plain", None), ("lz4", Writer1.CompressionFormat.LZ4), ("bz2", Writer1.CompressionFormat.BZ2)):
        bag1(f"ros1-{name}.bag", compression, rows)
    tilted("level.mcap", rows[:80], 0.05)
    tilted("planar.mcap", rows[:80], 0.0)
    dataflash("rover.bin", rows)
    vesc_tool("vesc-tool.csv", rows)


if __name__ == "__main__":
    main()

"""A DDS peer that shares nothing with gmr (Eclipse Cyclone DDS) hears `gmr node`, and tells it of the wheels.

    python peer.py GMR FOLDER

FOLDER has robot.toml, odometry.toml and drivers.toml (the same robot, read by its odometry, and by the power of its motor drivers), coefficients.toml and log.csv: 2 kg of payload, 12 V, all power.
Ends with 0 and what it found, or with the assertion that did not hold.
"""

import csv
import json
import math
import os
import subprocess
import sys
import time

from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsParticipant, BuiltinTopicDcpsPublication
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.internal import InvalidSample
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from messages import (
    BatteryState, DiagnosticArray, Float64, Header, JointState, ODriveStatus, Odometry, ParticipantEntitiesInfo, Pose, PoseWithCovariance,
    Quaternion, Time, Twist, TwistWithCovariance, Vector3,
)

SPEED = 8.0
PAYLOAD_KG = 2.0
# Below 101: ports above belong to whoever the system gives them.
DOMAIN = 1 + os.getpid() % 100
# As ROS 2 asks and offers unless told otherwise.
QOS = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.Volatile, Policy.History.KeepLast(10))


class Peer:
    """Everything that a process on the other side would have; `close` is as if it died."""

    def __init__(self):
        self.domain = DomainParticipant(DOMAIN)
        self.readers = {
            name: DataReader(self.domain, self.topic(name, kind), qos=QOS)
            for name, kind in [
                ("/battery_state", BatteryState), ("/payload", Float64), ("/payload/low", Float64), ("/payload/high", Float64),
                ("/diagnostics", DiagnosticArray),
            ]
        }
        self.writers = {}

    def topic(self, name, kind):
        return Topic(self.domain, "rt" + name, kind, qos=QOS)

    def tell(self, name, message):
        if name not in self.writers:
            self.writers[name] = DataWriter(self.domain, self.topic(name, type(message)), qos=QOS)
        self.writers[name].write(message)

    def heard(self, name):
        # A writer that goes leaves a sample without data behind.
        return [sample for sample in self.readers[name].take(100) if not isinstance(sample, InvalidSample)]


def node(gmr, folder, *arguments, robot="robot.toml", **options):
    command = [gmr, "node", "--robot", robot, "--coeffs", "coefficients.toml", "--replay", "log.csv", *arguments]
    return subprocess.Popen(command, cwd=folder, **options)


def same(a, b):
    return a == b or (math.isnan(a) and math.isnan(b))


def hears_what_the_node_knows(gmr, folder):
    """All numbers on the topics are those of --json, of which a run without a network says the same."""
    alone = node(gmr, folder, "--no-ros", "--speed", "max", "--json", stdout=subprocess.PIPE, text=True).communicate()[0]
    said = [json.loads(line) for line in alone.splitlines()]
    number = lambda key: [math.nan if line[key] is None else line[key] for line in said]
    expected = {"/payload": number("payload_kg"), "/payload/low": number("payload_low_kg"), "/payload/high": number("payload_high_kg")}
    peer = Peer()
    running = node(gmr, folder, "--speed", str(SPEED), "--domain", str(DOMAIN), stdout=subprocess.DEVNULL)
    found = {name: [] for name in expected}
    batteries, diagnostics = [], []
    while running.poll() is None:
        for name, numbers in found.items():
            numbers += [message.data for message in peer.heard(name)]
        batteries += peer.heard("/battery_state")
        diagnostics += peer.heard("/diagnostics")
        time.sleep(0.02)
    assert running.returncode == 0, running.returncode
    for name, numbers in found.items():
        # The first ones were sent before the two knew of each other.
        assert len(numbers) >= len(said) / 2, (name, len(numbers), len(said))
        end = expected[name][: len(expected[name])]
        while len(end) > len(numbers):
            end.pop(0)
        shifted = [end, expected[name][-len(numbers) - 1 : -1]]
        assert any(all(map(same, numbers, wanted)) for wanted in shifted), (name, numbers[-3:], end[-3:])
    payload = found["/payload"][-1]
    assert abs(payload - PAYLOAD_KG) < 0.1 * PAYLOAD_KG, payload
    assert found["/payload/low"][-1] < payload < found["/payload/high"][-1]
    last, line = batteries[-1], said[-1]
    assert last.voltage == 12.0 and last.present and last.power_supply_status == 2, last
    # The definition's sign: below 0 while it discharges.
    currents = {round(-entry["current_a"], 4) for entry in said}
    assert last.current < 0 and round(last.current, 4) in currents, (last.current, line["current_a"])
    assert math.isclose(last.percentage, line["charge"], abs_tol=0.01) and math.isclose(last.design_capacity, 1.8, rel_tol=1e-6)
    assert math.isclose(last.charge, 1.8 * last.percentage, rel_tol=1e-4)
    assert all(map(math.isnan, [last.temperature, last.capacity])), last
    assert abs(last.header.stamp.sec - time.time()) < 60
    (status,) = diagnostics[-1].status
    values = {pair.key: pair.value for pair in status.values}
    assert status.level == 0 and status.hardware_id == "exact", status
    assert math.isclose(float(values["payload_kg"]), payload, rel_tol=0.05), values
    print(f"heard {len(batteries)} battery states, {len(found['/payload'])} payloads; the last {payload:.3f} kg")


def joints(row, stamp):
    header = Header(Time(int(stamp), int(stamp % 1 * 1e9)), "")
    left, right = (float(row[f"wheel{wheel}_rad_s"]) for wheel in (1, 2))
    # In another order than the log, and with a joint that is none of ours.
    names = ["wheel_right_joint", "gripper", "wheel_left_joint"]
    return JointState(header, names, [0.0] * 3, [right, 7.0, left], [0.0] * 3)


def odometry(row, stamp):
    """The motion of robot.toml's kinematics: r = 0.033 m, b = 0.16 m."""
    header = Header(Time(int(stamp), int(stamp % 1 * 1e9)), "odom")
    left, right = (float(row[f"wheel{wheel}_rad_s"]) for wheel in (1, 2))
    forward, turn = 0.033 * (left + right) / 2, 0.033 * (right - left) / 0.16
    zero, around = Vector3(0.0, 0.0, 0.0), [1.0] * 36
    twist = Twist(Vector3(forward, 0.0, 0.0), Vector3(0.0, 0.0, turn))
    pose = PoseWithCovariance(Pose(zero, Quaternion(0.0, 0.0, 0.0, 1.0)), around)
    return Odometry(header, "base_link", pose, TwistWithCovariance(twist, around))


class Told:
    """`gmr node` with its speeds from here, in step with the log."""

    def __init__(self, gmr, folder, name, message, robot):
        self.rows = list(csv.DictReader(open(os.path.join(folder, "log.csv"))))
        self.name, self.message = name, message
        arguments = ["--wheels", "topic", "--speed", str(SPEED), "--domain", str(DOMAIN), "--json"]
        self.states, self.next, self.torn = [], 0, ""
        with open(os.path.join(folder, "states.jsonl"), "w") as to:
            self.running = node(gmr, folder, *arguments, robot=robot, stdout=to)
        self.out = open(os.path.join(folder, "states.jsonl"))
        # The log begins with the node: its first state tells when that was.
        while not self.look():
            assert self.running.poll() is None, self.running.returncode
            time.sleep(0.005)
        self.began = time.time() - self.states[-1]["time_s"] / SPEED

    def look(self):
        # A line may be half written: the rest comes with the next look.
        *lines, self.torn = (self.torn + self.out.read()).split("\n")
        self.states += [json.loads(line) for line in lines]
        return lines

    def until(self, end, peer, offset, speaks=True):
        """To `end` s of the log; stamps are `offset` s off."""
        payloads, batteries, levels = [], [], []
        while (now := (time.time() - self.began) * SPEED) < end:
            while self.next < len(self.rows) and float(self.rows[self.next]["time_s"]) <= now:
                row, self.next = self.rows[self.next], self.next + 1
                if speaks:
                    peer.tell(self.name, self.message(row, float(row["time_s"]) + offset))
            payloads += [message.data for message in peer.heard("/payload")]
            batteries += peer.heard("/battery_state")
            levels += [message.status[0].level for message in peer.heard("/diagnostics")]
            self.look()
            time.sleep(0.001)
        return payloads, batteries, levels

    def end(self):
        self.running.kill()
        self.running.wait()


def is_payload(payload):
    return abs(payload - PAYLOAD_KG) < 0.1 * PAYLOAD_KG


def tells_of_the_wheels(gmr, folder):
    """Speeds that come, stop, and come again from another process with another clock."""
    peer = Peer()
    told = Told(gmr, folder, "/joint_states", joints, "robot.toml")
    payloads, batteries, levels = told.until(45, peer, 1.7e9)
    assert payloads and is_payload(payloads[-1]), (payloads[-5:], told.states[-1])
    assert levels[-1] == 0 and batteries[-1].voltage == 12.0
    print(f"told of the wheels: {payloads[-1]:.3f} kg at {told.states[-1]['rate_hz']:.1f} Hz, faults {told.states[-1]['faults']}")

    payloads, batteries, levels = told.until(52, peer, 0, speaks=False)
    assert math.isnan(payloads[-1]) and levels[-1] == 3, (payloads, levels)
    assert told.states[-1]["state"] == "no-speeds" and batteries[-1].voltage == 12.0, told.states[-1]
    print(f"silent for 7 s: {payloads[-1]}, and \"{told.states[-1]['why']}\"")

    del peer
    peer = Peer()
    payloads, _, levels = told.until(95, peer, -1000.0 + 1.7e9)
    assert is_payload(payloads[-1]) and levels[-1] == 0, (payloads[-5:], told.states[-1])
    assert told.states[-1]["faults"]["new sender of speeds"] == 1, told.states[-1]
    print(f"another process with another clock: {payloads[-1]:.3f} kg")
    told.end()


def tells_of_odometry(gmr, folder):
    peer = Peer()
    told = Told(gmr, folder, "/odom", odometry, "odometry.toml")
    payloads, _, _ = told.until(45, peer, 0.5)
    assert payloads and is_payload(payloads[-1]), (payloads[-5:], told.states[-1])
    print(f"told of odometry: {payloads[-1]:.3f} kg")
    told.end()


# As ROS 2's own nodes keep it for whoever comes later.
GRAPH = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.TransientLocal, Policy.History.KeepLast(1))


def is_in_the_graph(domain, readers):
    """What `ros2 node list` is made of, heard by a peer that comes later: a node, and endpoints that are there."""
    info = DataReader(domain, Topic(domain, "ros_discovery_info", ParticipantEntitiesInfo, qos=GRAPH), qos=GRAPH)
    keys = lambda topic: {sample.key.bytes for sample in BuiltinDataReader(domain, topic).take(100)}
    end, found = time.time() + 5, []
    while time.time() < end and not (found and len(found[-1].node_entities_info_seq[0].reader_gid_seq) == readers):
        found += [sample for sample in info.take(10) if not isinstance(sample, InvalidSample)]
        time.sleep(0.02)
    (node,) = found[-1].node_entities_info_seq
    assert (node.node_namespace, node.node_name) == ("/", "gmr_node"), node
    assert bytes(found[-1].gid.data) in keys(BuiltinTopicDcpsParticipant)
    written = {bytes(gid.data) for gid in node.writer_gid_seq}
    assert len(written) == 9 and written <= keys(BuiltinTopicDcpsPublication), node
    assert len(node.reader_gid_seq) == readers, node
    print(f"in the graph: {node.node_namespace}{node.node_name}, {len(written)} topics told, {readers} heard")


def adds_up_what_drivers_say(gmr, folder):
    """Power of two motor drivers, no sensor; one falls silent: within a second the payload is unknown, and it is said why."""
    rows = list(csv.DictReader(open(os.path.join(folder, "log.csv"))))
    peer = Peer()
    command = [gmr, "node", "--robot", "drivers.toml", "--coeffs", "coefficients.toml", "--domain", str(DOMAIN), "--json"]
    with open(os.path.join(folder, "drivers.jsonl"), "w") as to:
        running = subprocess.Popen(command, cwd=folder, stdout=to)
    began, payloads, messages, silent_at, unknown_at = time.time(), [], [], None, None
    for row in rows:
        time.sleep(max(0.0, began + float(row["time_s"]) - time.time()))
        peer.tell("/joint_states", joints(row, float(row["time_s"]) + 1.7e9))
        half = float(row["power_w"]) / 2 / 12.0
        peer.tell("/left/odrive_status", ODriveStatus(12.0, half, 30.0, 30.0, 0, 0))
        if silent_at is None:
            # Mounted the other way round, and in mV.
            peer.tell("/right/odrive_status", ODriveStatus(12000.0, -half, 30.0, 30.0, 0, 0))
        heard = [message.data for message in peer.heard("/payload")]
        payloads += heard
        messages += [message.status[0] for message in peer.heard("/diagnostics")]
        if silent_at is not None and heard and math.isnan(heard[-1]):
            unknown_at = time.time()
            break
        if silent_at is None and float(row["time_s"]) > 45:
            assert payloads and is_payload(payloads[-1]), (payloads[-5:], messages[-1:])
            known = payloads[-1]
            is_in_the_graph(peer.domain, 3)
            silent_at = time.time()
            began = silent_at - float(row["time_s"])
    assert unknown_at is not None and unknown_at - silent_at < 1.0, (silent_at, unknown_at)
    time.sleep(0.1)
    messages += [message.status[0] for message in peer.heard("/diagnostics")]
    assert messages[-1].level == 2 and "/right/odrive_status is silent" in messages[-1].message, messages[-1]
    print(f"power of two drivers: {known:.3f} kg; unknown {unknown_at - silent_at:.2f} s after one fell silent: \"{messages[-1].message}\"")
    running.kill()
    running.wait()


if __name__ == "__main__":
    gmr, folder = sys.argv[1:]
    hears_what_the_node_knows(gmr, folder)
    tells_of_the_wheels(gmr, folder)
    tells_of_odometry(gmr, folder)
    adds_up_what_drivers_say(gmr, folder)

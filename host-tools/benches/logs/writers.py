"""A drive, repeated until the file has its size, without anything of gmr: `WRITERS` is {format: (file, writer)}. Messages are serialized by PyPI's rosbags,
once, and then differ by their stamp and numbers only; who writes them one by one takes minutes a gigabyte.

A writer takes the drive, the file and the size, bytes, and gives the rows that it wrote. Row i is at i times the drive's period: whole microseconds, so that
every format has the same times. Wheel speeds, power and mass are columns in tables, and topics of their own, stamped alike, in bags and ULog.
"""

import itertools
import sqlite3
import struct

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from rosbags.typesys import Stores, get_typestore

TYPES = get_typestore(Stores.ROS2_JAZZY)
MAGIC = b"\x89MCAP0\r\n"
START_NS = 1_760_000_000_000_000_000
COLUMNS = ["time_s", "wheel1_rad_s", "wheel2_rad_s", "power_w", "mass_kg"]
WHEELS = ["wheel_left_joint", "wheel_right_joint"]


class Drive:
    """Of `gmr simulate`; `columns` is n x 4, without time."""

    def __init__(self, path):
        numbers = np.loadtxt(path, delimiter=",", skiprows=1)
        with open(path) as file:
            assert file.readline().strip().split(",") == COLUMNS
        self.columns = np.ascontiguousarray(numbers[:, 1:])
        self.period_us = round((numbers[1, 0] - numbers[0, 0]) * 1e6)

    def turns(self):
        """Once more and once more: times, µs, and columns."""
        count = len(self.columns)
        for turn in itertools.count():
            yield (turn * count + np.arange(count)) * self.period_us, self.columns


def csv(drive, path, size=None, rows=None):
    tails = [",".join(map(repr, row)) for row in drive.columns.tolist()]
    with open(path, "w") as file:
        file.write(",".join(COLUMNS) + "\n")
        written = 0
        for times, _ in drive.turns():
            left = len(tails) if rows is None else min(len(tails), rows - written)
            file.write("".join(f"{us / 1e6:.6f},{tail}\n" for us, tail in zip(times[:left].tolist(), tails)))
            written += left
            if written == rows or (size and file.tell() >= size):
                return written


def parquet(drive, path, size):
    schema = pa.schema([(name, pa.float64()) for name in COLUMNS])
    written = 0
    # Numbers of a sensor seldom come twice; those of a repeated drive would fit into a dictionary.
    with pq.ParquetWriter(path, schema, use_dictionary=False) as to:
        for times, columns in drive.turns():
            to.write_table(pa.table([times / 1e6, *columns.T], schema=schema))
            written += len(times)
            if path.stat().st_size >= size:
                return written


def ulog(drive, path, size):
    """By docs.px4.io/main/en/dev_log/ulog_file_format.html. The right wheel is the first, as in PX4's Roboclaw driver."""
    topics = [("wheel_encoders", "double[2] wheel_speed", [1, 0]), ("drive_power", "double power_w", [2]), ("payload", "double mass_kg", [3])]
    record = lambda kind, body: struct.pack("<HB", len(body), ord(kind)) + body
    head = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + record("B", bytes(40))
    head += b"".join(record("F", f"{name}:uint64_t timestamp;{field};".encode()) for name, field, _ in topics)
    head += b"".join(record("A", struct.pack("<BH", 0, place) + name.encode()) for place, (name, _, _) in enumerate(topics))
    fields = [[("size", "<u2"), ("kind", "u1"), ("id", "<u2"), ("time", "<u8"), ("value", "<f8", len(places))] for _, _, places in topics]
    data = np.zeros(len(drive.columns), [(name, field) for (name, _, _), field in zip(topics, fields)])
    for place, (name, _, places) in enumerate(topics):
        part = data[name]
        part["size"], part["kind"], part["id"] = 10 + 8 * len(places), ord("D"), place
        part["value"] = drive.columns[:, places] if len(places) > 1 else drive.columns[:, places].reshape(part["value"].shape)
    written = 0
    with open(path, "wb") as file:
        file.write(head)
        for times, _ in drive.turns():
            for name, _, _ in topics:
                data[name]["time"] = 1_000_000 + times
            data.tofile(file)
            written += len(times)
            if file.tell() >= size:
                return written


class Template:
    """Messages of one type that differ in stamp and numbers only: where those lie is found by writing them."""

    def __init__(self, kind, make, numbers):
        marks = [1e300 + 1e290 * place for place in range(numbers)]
        self.bytes = np.frombuffer(bytes(TYPES.serialize_cdr(make(0x11223344, 0x55667788, marks), kind)), np.uint8)
        raw = self.bytes.tobytes()
        self.places = [raw.index(struct.pack("<d", mark)) for mark in marks]
        stamp = struct.pack("<iI", 0x11223344, 0x55667788)
        self.stamp = raw.find(stamp)

    def messages(self, ns, numbers):
        """As many messages, a row of bytes each."""
        rows = np.tile(self.bytes, (len(ns), 1))
        if self.stamp >= 0:
            rows[:, self.stamp : self.stamp + 4] = (ns // 10**9).astype("<i4")[:, None].view(np.uint8)
            rows[:, self.stamp + 4 : self.stamp + 8] = (ns % 10**9).astype("<u4")[:, None].view(np.uint8)
        for place, column in zip(self.places, numbers.T):
            rows[:, place : place + 8] = np.ascontiguousarray(column)[:, None].view(np.uint8)
        return rows


def joints(sec, nanosec, speeds):
    header = TYPES.types["std_msgs/msg/Header"](TYPES.types["builtin_interfaces/msg/Time"](sec, nanosec), "")
    zeros = np.zeros(2)
    return TYPES.types["sensor_msgs/msg/JointState"](header, WHEELS, zeros, np.array(speeds), zeros)


def number(_sec, _nanosec, value):
    return TYPES.types["std_msgs/msg/Float64"](value[0])


def topics():
    """(name, type, template, columns)."""
    float64 = "std_msgs/msg/Float64"
    return [
        ("/joint_states", "sensor_msgs/msg/JointState", Template("sensor_msgs/msg/JointState", joints, 2), [0, 1]),
        ("/power", float64, Template(float64, number, 1), [2]),
        ("/total_mass", float64, Template(float64, number, 1), [3]),
    ]


def mcap(drive, path, size):
    """By mcap.dev/spec, without chunks and summary: a second's worth of messages is laid out at once."""
    text = lambda text: struct.pack("<I", len(text)) + text.encode()
    record = lambda op, body: struct.pack("<BQ", op, len(body)) + body
    head = MAGIC + record(1, text("ros2") + text(""))
    parts, columns_of = [], []
    for place, (name, kind, template, columns) in enumerate(topics(), 1):
        definition = TYPES.generate_msgdef(kind, ros_version=2)[0]
        head += record(3, struct.pack("<H", place) + text(kind) + text("ros2msg") + text(definition))
        head += record(4, struct.pack("<HH", place, place) + text(name) + text("cdr") + struct.pack("<I", 0))
        fields = [("op", "u1"), ("size", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("log", "<u8"), ("published", "<u8")]
        parts.append((name, [*fields, ("data", "u1", len(template.bytes))]))
        columns_of.append((name, template, columns))
    data = np.zeros(len(drive.columns), parts)
    for place, (name, template, _) in enumerate(columns_of, 1):
        data[name]["op"], data[name]["channel"], data[name]["size"] = 5, place, 22 + len(template.bytes)
    written = 0
    with open(path, "wb") as file:
        file.write(head)
        for times, columns in drive.turns():
            ns = START_NS + times * 1000
            for name, template, places in columns_of:
                data[name]["log"] = data[name]["published"] = ns
                data[name]["sequence"] = written + np.arange(len(times))
                data[name]["data"] = template.messages(ns, columns[:, places])
            data.tofile(file)
            written += len(times)
            if file.tell() >= size:
                break
        file.write(record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + MAGIC)
    return written


def sqlite(drive, path, size):
    """As rosbag2's recorder lays its tables out (rosbag2_storage_sqlite3, schema 4)."""
    path.unlink(missing_ok=True)
    to = sqlite3.connect(path, isolation_level=None)
    to.executescript("""
        PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF;
        CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
        CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
            offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
        CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
            encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
        CREATE INDEX timestamp_idx ON messages (timestamp ASC);
        INSERT INTO schema VALUES (4, 'jazzy');
    """)
    known = topics()
    for place, (name, kind, _, _) in enumerate(known, 1):
        to.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '', '')", (place, name, kind))
    for kind in {kind for _, kind, _, _ in known}:
        definition = TYPES.generate_msgdef(kind, ros_version=2)[0]
        to.execute("INSERT INTO message_definitions (topic_type, encoding, encoded_message_definition, type_description_hash) VALUES (?, 'ros2msg', ?, '')", (kind, definition))
    written = 0
    for times, columns in drive.turns():
        ns = START_NS + times * 1000
        messages = []
        for place, (_, _, template, places) in enumerate(known, 1):
            rows = template.messages(ns, columns[:, places])
            messages.append([(place, at, row.data) for at, row in zip(ns.tolist(), rows)])
        to.execute("BEGIN")
        together = itertools.chain.from_iterable(zip(*messages))
        to.executemany("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", together)
        to.execute("COMMIT")
        written += len(times)
        if path.stat().st_size >= size:
            break
    to.close()
    return written


WRITERS = {
    "CSV": ("log.csv", csv),
    "Parquet": ("log.parquet", parquet),
    "MCAP": ("log.mcap", mcap),
    "ULog": ("log.ulg", ulog),
    ".db3": ("log.db3", sqlite),
}

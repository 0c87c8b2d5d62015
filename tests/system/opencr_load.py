"""Floods and full load on the OpenCR image in the emulated STM32F746: samples a second, how late each begins, and how long the ROS node waits for its block.

    PYTHONPATH=folder/of/emu:tests/system emu tests/system/opencr_load.py IMAGE [--cpi 3] [--seconds 2] [--only WORD] [--json]

Every instruction takes three cycles unless asked otherwise: more than flash and buses of the real chip cost. The robot drives by the node's
commands; the inertial sensor turns with it. In each row the node asks for its 172-byte block 20 times a second and gmr for every record, except
on a port that is flooded. Lateness is between when a sample was due and when the board looked at its clock to begin it, in us; latency between a
host that asks and the answer's last packet, in ms. At least 195 samples a second, or it fails.
"""
import argparse
import collections
import json
import struct
import sys

from board import MS, PS, US, run
from opencr_emulated import Host, Node, Recorder, set_up, upload
from opencr_inertial import Sensor
from protocol import answers, packet

LEAST_SAMPLES = 195
PERIOD_US = 5000
BLOCK = 10, 172
# The node gives up after this.
PATIENCE_S = 0.0358
# The second port's endpoint, as the builder numbers them.
GMR_OUT = 2
DRIVE = (10, 0)
TIM5_COUNT = 0x40000C24

HEADERS = b"\xff\xff\xfd\x00" * 16
NOISE = bytes(range(64))
PINGS = bytes.fromhex("fffffd00c80300013bfa") * 6
WRITES = packet(3, struct.pack("<H", 840) + bytes(range(240)))
WHOLE_TABLE = packet(2, struct.pack("<HH", 0, 2440))


class BusyNode(Node):
    """The node, which looks for its answers as often as a real host's controller does."""

    def __init__(self, machine):
        self.asked, self.latencies, self.lost, self.is_asking = [], [], 0, False
        super().__init__(machine)
        self.ask()

    def wait(self):
        usb = self.machine.otg
        if self.machine.host.bulk:
            if self.queue and usb.tok_out(self.OUT, self.queue[0]) is True:
                self.queue.pop(0)
            answer = usb.tok_in(self.IN)
            if isinstance(answer, bytes) and answer:
                self.bytes += answer
                self.take()
        self.machine.after(20 * US, self.wait, keep=True)

    def take(self):
        for body in answers(self.bytes):
            if len(body) == 2 + BLOCK[1] and self.asked:
                self.latencies.append((self.machine.now() - self.asked.pop(0)) / PS)

    def ask(self):
        late = [then for then in self.asked if self.machine.now() - then > PATIENCE_S * PS]
        self.lost += len(late)
        self.asked = [then for then in self.asked if then not in late]
        if self.is_asking:
            self.asked.append(self.machine.now())
            self.queue.append(packet(2, struct.pack("<HH", *BLOCK)))
        self.machine.after(50 * MS, self.ask, keep=True)


class Flood:
    """Bytes without end on a port: as many of them a second as the board takes of what is offered. Answers are fetched."""

    def __init__(self, machine, endpoint, data, megabytes_s):
        self.machine, self.endpoint, self.is_on = machine, endpoint, True
        self.packets = [data[i : i + 64] for i in range(0, len(data), 64)]
        self.pause, self.at, self.taken, self.begun = int(64 / (megabytes_s * 1e6) * PS), 0, 0, machine.now()
        self.more()

    def more(self):
        if self.is_on:
            if self.machine.otg.tok_out(self.endpoint, self.packets[self.at]) is True:
                self.taken += len(self.packets[self.at])
                self.at = (self.at + 1) % len(self.packets)
            self.machine.after(self.pause, self.more, keep=True)

    def end(self):
        self.is_on = False
        return self.taken / ((self.machine.now() - self.begun) / PS)


# Name: port that is flooded, with what, megabytes a second offered, and a fault of a bus.
LOADS = {
    "node and gmr": (None, b"", 0, None),
    "flood of headers, gmr's port": (GMR_OUT, HEADERS, 1.2, None),
    "flood of noise, gmr's port": (GMR_OUT, NOISE, 1.2, None),
    "flood of pings, gmr's port": (GMR_OUT, PINGS, 1.2, None),
    "flood of writes, gmr's port": (GMR_OUT, WRITES, 1.2, None),
    "flood of reads of all, gmr's port": (GMR_OUT, WHOLE_TABLE, 1.2, None),
    "flood of headers, node's port": (Node.OUT, HEADERS, 1.2, None),
    "flood of noise, node's port": (Node.OUT, NOISE, 1.2, None),
    "flood of pings, node's port": (Node.OUT, PINGS, 1.2, None),
    "flood of reads of all, node's port": (Node.OUT, WHOLE_TABLE, 1.2, None),
    "the same, a sensor absent": (Node.OUT, WHOLE_TABLE, 1.2, "absent"),
    "the same, SDA low": (Node.OUT, WHOLE_TABLE, 1.2, "sda_low"),
    "the same, left servo dead": (Node.OUT, WHOLE_TABLE, 1.2, "servo"),
    "the same, servo packets corrupted": (Node.OUT, WHOLE_TABLE, 1.2, "corrupt"),
}


def set_fault(machine, fault, is_on):
    if fault == "absent":
        machine.i2c[1].devs[0x44].present = not is_on
    elif fault == "servo":
        machine.servos[0].alive = not is_on
    elif fault == "corrupt":
        machine.dxl.corrupt_next = 10**6 if is_on else 0
    elif fault:
        machine.i2c[1].fault = fault if is_on else None


def spread(values, scale, digits):
    """Least, median, 99 %, most."""
    if not values:
        return None
    values = sorted(values)
    at = (0, len(values) // 2, min(len(values) - 1, len(values) * 99 // 100), len(values) - 1)
    return [round(values[i] * scale, digits) for i in at]


class Bench:
    def __init__(self, image, cpi):
        self.machine = set_up(argparse.Namespace(image=image, absent=[], silent_servo=[]), cpi=cpi)
        Sensor(self.machine, "mpu9250")
        self.host, self.node = Host(self.machine), BusyNode(self.machine)
        run(self.machine, 1.5)
        upload(self.machine, self.host)
        self.drive()
        run(self.machine, 0.5)
        self.recorder = Recorder(self.machine, self.host)
        run(self.machine, 0.5)
        # When samples are due, µs within a period: most of those that nothing disturbs begin then.
        phases = collections.Counter(record[1] % PERIOD_US for record in self.recorder.records)
        self.due = phases.most_common(1)[0][0]

    def drive(self):
        self.node.command(*DRIVE)
        self.machine.after(100 * MS, self.drive, keep=True)

    def board_us(self):
        return struct.unpack("<I", self.machine.mread(TIM5_COUNT, 4))[0]

    def row(self, name, seconds):
        endpoint, data, rate, fault = LOADS[name]
        machine, node, host = self.machine, self.node, self.host
        node.latencies, node.lost, node.asked, node.bytes = [], 0, [], bytearray()
        node.is_asking = endpoint != Node.OUT
        latencies, asked = [], []
        if endpoint == Node.OUT:
            # Its port is taken: the block's latency on the other one, beside the recorder.
            def ask():
                begun = machine.now()
                host.read(*BLOCK, lambda _: latencies.append((machine.now() - begun) / PS))
                if asked and machine.now() < asked[0]:
                    machine.after(50 * MS, ask, keep=True)

            asked.append(machine.now() + int(seconds * PS))
            ask()
        self.recorder.is_on = endpoint != GMR_OUT
        slept, began, first = machine.sleep_ps, machine.now(), self.board_us()
        set_fault(machine, fault, True)
        flood = Flood(machine, endpoint, data, rate) if endpoint else None
        run(machine, seconds)
        taken = flood.end() if flood else 0
        idle = (machine.sleep_ps - slept) / (machine.now() - began)
        last = self.board_us()
        set_fault(machine, fault, False)
        node.is_asking = False
        # What comes back of the flood is nobody's, the answer under way too.
        run(machine, 0.05)
        host.waiting.clear()
        host.bytes.clear()
        self.recorder.is_on = True
        run(machine, 1.0)
        records = {record[0]: record[1] for record in self.recorder.records if first <= record[1] < last}
        late = [(time - self.due) % PERIOD_US for time in records.values()]
        waited = node.latencies if endpoint != Node.OUT else latencies
        found = {
            "load": name,
            "taken_kB_s": round(taken / 1e3),
            "samples_s": round(len(records) / ((last - first) / 1e6), 1),
            "late_us": spread(late, 1, 0),
            "block_ms": spread(waited, 1e3, 2),
            "blocks": len(waited),
            "blocks_lost": node.lost,
            "idle_percent": round(100 * idle, 1),
        }
        self.recorder.records.clear()
        found["wrong"] = [f"{found['samples_s']} samples a second"] if found["samples_s"] < LEAST_SAMPLES else []
        return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("image")
    parser.add_argument("--cpi", type=float, default=3.0)
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--only", default="")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    bench, rows = Bench(arguments.image, arguments.cpi), []
    for name in LOADS:
        if arguments.only in name:
            found = bench.row(name, arguments.seconds)
            rows.append(found)
            if not arguments.json:
                print("  ".join(f"{key} {value}" for key, value in found.items()), flush=True)
    if arguments.json:
        print(json.dumps(rows))
    sys.exit(1 if any(found["wrong"] for found in rows) else 0)


if __name__ == "__main__":
    main()

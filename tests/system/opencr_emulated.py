"""Boots the OpenCR image in the emulated STM32F746, gives it coefficients over its USB link, lets the wheels turn, reads
every record and checks what it says.

    PYTHONPATH=folder/of/emu emu opencr_emulated.py IMAGE [--seconds S] [--absent ADDRESS] [--silent-servo ID] [--bus-faults] [--json]
    PYTHONPATH=folder/of/emu emu opencr_emulated.py IMAGE [--seconds S] --terminal LINK

The second form checks nothing: the link is a pseudo terminal for another program, in real time, and the robot stops and goes.

The registers and packets are written here from docs/link.md and the e-manual's Protocol 2.0, not taken from the firmware.
"""
import argparse
import json
import math
import struct
import sys
import zlib

from board import MS, PS, Fault, make, run
import devices
import ptylink
from protocol import BOARD, checksum, packet

RECORD = struct.Struct("<IQ2f4ffHHf3f")
WINDOW = 16
# Registers: address, format.
REGISTERS = {
    "table_version": (512, "H"),
    "model": (518, "B"),
    "coefficients_state": (519, "B"),
    "uptime_us": (548, "Q"),
    "rail_power": (556, "4f"),
    "rail_health": (620, "4B"),
    "rail_counters": (624, "20I"),
    "wheel_health": (720, "2B"),
    "samples": (792, "I"),
    "missed_deadlines": (796, "I"),
    "servo_timeouts": (800, "I"),
    "servo_broken": (804, "I"),
    "bus_errors": (808, "I"),
    "bus_recoveries": (812, "I"),
    "link_broken": (820, "I"),
    "fifo_lost": (824, "I"),
    "upload_state": (836, "B"),
}
UPLOAD_ITEM, UPLOAD_WINDOW = 832, 840
FIFO_ACKNOWLEDGE = 1352
# Of each rail: INA219 address, shunt voltage in 10 uV over 0.1 ohm, bus voltage in 4 mV.
RAILS = {0x40: (8000, 2775), 0x41: (2500, 2770), 0x44: (9000, 1265), 0x45: (3500, 1260)}
RATE = 200
# What is commanded, in 0.01 m/s and 0.01 rad/s, and the goals that the stock firmware makes of it, in 0.229 rev/min.
COMMAND = (6, -20)
GOALS = tuple(int((COMMAND[0] / 100 + side * COMMAND[1] / 100 * 0.080) * 1263.633) for side in (-1, 1))
PAINT = 0xCCCCCCCC
STACK = (0x20000000, 0x10000)
# Between two moments at which a sensor goes, in us: a transaction takes 120, of which it can go unseen by the driver in some 50.
SWITCH_OUT_US = 47
# The host has found the board, and the wheels have stood for the second after which the flash may be written.
SETTLED_S = 1.5
# The flash has been written.
STORED_S = 1.0


class Host:
    """Asks one thing after the other; each answer goes to whoever asked."""

    def __init__(self, machine):
        self.machine, self.bytes, self.waiting, self.broken = machine, bytearray(), [], 0
        machine.host.on_rx = self.receive

    def read(self, address, length, then):
        self.ask(packet(2, struct.pack("<HH", address, length)), then)

    def write(self, address, data):
        self.ask(packet(3, struct.pack("<H", address) + data), lambda _: None)

    def ask(self, request, then):
        self.waiting.append((request, then))
        if len(self.waiting) == 1:
            self.machine.host.write(request)

    def receive(self, data):
        self.bytes += data
        while True:
            start = self.bytes.find(b"\xff\xff\xfd\x00")
            if start < 0 or len(self.bytes) < start + 7:
                return
            end = start + 7 + struct.unpack_from("<H", self.bytes, start + 5)[0]
            if len(self.bytes) < end:
                return
            found, self.bytes = bytes(self.bytes[start:end]), self.bytes[end:]
            body = found[7:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
            is_good = checksum(found[:-2]) == struct.unpack("<H", found[-2:])[0]
            if not is_good or found[4] != BOARD or body[:2] != b"\x55\x00" or not self.waiting:
                self.broken += 1
                continue
            _, then = self.waiting.pop(0)
            if self.waiting:
                self.machine.host.write(self.waiting[0][0])
            then(body[2:])


class Recorder:
    """Fetches every record from now on: 14 a time, of the 16 that the window holds."""

    def __init__(self, machine, host):
        self.machine, self.host, self.records, self.is_on = machine, host, [], True
        self.poll()

    def poll(self):
        if self.is_on:
            self.host.read(FIFO_ACKNOWLEDGE, 16 + WINDOW * RECORD.size, self.take)
        self.machine.after(70 * MS, self.poll, keep=True)

    def take(self, data):
        count, size = struct.unpack_from("<HH", data, 12)
        if size != RECORD.size:
            raise SystemExit(f"records of {size} bytes")
        if count:
            new = list(RECORD.iter_unpack(data[16 : 16 + count * size]))
            self.records += new
            self.host.write(FIFO_ACKNOWLEDGE, struct.pack("<I", (new[-1][0] + 1) & 0xFFFFFFFF))
            if count == WINDOW:
                # There are more: the first window begins with the start.
                self.host.read(FIFO_ACKNOWLEDGE, 16 + WINDOW * RECORD.size, self.take)


def registers(machine, host):
    found = {}
    first, last = 512, 840

    def take(data):
        for name, (address, form) in REGISTERS.items():
            values = struct.unpack_from("<" + form, data, address - first)
            found[name] = values if len(values) > 1 else values[0]

    host.read(first, last - first, take)
    run(machine, 0.2)
    if not found:
        raise SystemExit("the board does not answer on its link")
    return found


def stack_bytes(machine):
    words = struct.unpack(f"<{STACK[1] // 4}I", machine.uc.mem_read(*STACK))
    untouched = next((i for i, word in enumerate(words) if word != PAINT), len(words))
    return STACK[1] - 4 * untouched


class Sensor(devices.INA219):
    """As the chip, unlike the emulator's: all registers are of one conversion, which writing the set-up begins."""

    CONVERSION_S = 4e-3

    def __init__(self, machine, shunt, bus):
        super().__init__(machine, shunt, bus)
        self.begun, self.seen = None, (0, 0)

    def write(self, byte):
        done = super().write(byte)
        if self.ptr == 0 and self.n == 3:
            now = self.m.now() / PS
            self.begun = now, (self.shunt(now), self.bus(now))
        return done

    def value(self, pointer):
        if self.begun and self.m.now() / PS - self.begun[0] >= self.CONVERSION_S:
            self.seen, self.begun = self.begun[1], None
        live = self.shunt, self.bus
        self.shunt, self.bus = (lambda _, seen=seen: seen for seen in self.seen)
        value = super().value(pointer)
        self.shunt, self.bus = live
        return value


def set_up(arguments, **chip):
    # Without the log: the emulator looks for it in memory every millisecond, also while that is being initialised.
    machine = make(elf=arguments.image, dirty=True, rtt=False, log=lambda *_: None, **chip)
    for address, (shunt, bus) in RAILS.items():
        sensor = Sensor(machine, shunt=lambda t, v=shunt: v, bus=lambda t, v=bus: v)
        sensor.present = address not in arguments.absent
        machine.i2c[1].devs[address] = sensor
    for servo in machine.servos:
        servo.alive = servo.id not in arguments.silent_servo
    return machine


class Node:
    """What the ROS node does on the first port, as far as it drives: a heartbeat ten times a second, and commands."""

    IN, OUT = 2, 1  # endpoints

    def __init__(self, machine):
        self.machine, self.queue, self.bytes, self.count, self.lives = machine, [], bytearray(), 0, True
        self.wait()
        self.beat()

    def wait(self):
        """Now and again: the emulator's host serves the other port, and only that."""
        usb = self.machine.otg
        if self.machine.host.bulk:
            if self.queue and usb.tok_out(self.OUT, self.queue[0]) is True:
                self.queue.pop(0)
            answer = usb.tok_in(self.IN)
            if isinstance(answer, bytes):
                self.bytes += answer
        self.machine.after(MS // 2, self.wait, keep=True)

    def beat(self):
        if self.lives:
            self.count = (self.count + 1) % 256
            self.write(19, bytes([self.count]))
        self.machine.after(100 * MS, self.beat, keep=True)

    def write(self, address, data):
        self.queue.append(packet(3, struct.pack("<H", address) + data))

    def command(self, linear, angular):
        self.write(150, struct.pack("<6i", linear, 0, 0, 0, 0, angular))


def turn(machine):
    """Drives as the node asks. Its heartbeat counts from the second one on."""
    node = Node(machine)
    machine.after(300 * MS, lambda: node.command(*COMMAND), keep=True)
    return node


def coefficients():
    """For the robot that a board without a store takes itself for: signed torque model of a small servo."""
    radius, track = 0.033, 0.160
    r, o = radius / 2, radius / track
    head = struct.pack("<4sHHBBBB24s", b"GMRC", 1, 164, 2, 0, 2, 0, b"TurtleBot3 Burger")
    # Gyration radius, dead band, cutoff, masses, static power; noise; torque.
    numbers = (0.064, 0.02, 2.0, 1.0, 6.0, 0.5, 0.003, 0.01, 1.5, 1.0, 0.04, 0.012, 0.006, 0.0081, 1.33, 6.5)
    body = head + struct.pack("<25f", *numbers, *[0.0] * 9) + struct.pack("<6f", r, r, 0.0, 0.0, -o, o)
    return body + struct.pack("<I", zlib.crc32(body))


def upload(machine, host):
    image = coefficients()
    host.write(UPLOAD_WINDOW, image)
    # Item 1, and the command behind it, in one packet with the length.
    host.write(UPLOAD_ITEM, struct.pack("<BBH", 1, 1, len(image)))
    run(machine, STORED_S)


# Of each drive, and of the rest before it.
STOP_AND_GO_S = 6.0


def stop_and_go(machine):
    """Stands, drives with changing speed, stands; the motors' rail carries more the faster the wheels turn."""
    node = Node(machine)

    def drive():
        phase = machine.now() / PS % (2 * STOP_AND_GO_S)
        # 0.01 m/s are 12.6 units of a goal.
        node.command(0 if phase < STOP_AND_GO_S else round(12 + 6 * math.sin(2 * phase)), 0)
        machine.after(50 * MS, drive, keep=True)

    drive()
    machine.i2c[1].devs[0x41].shunt = lambda t: 1000 + 10 * sum(abs(servo.vel) for servo in machine.servos)


def disturb(machine, host):
    """Every fault of the sensors' bus for half a second, each followed by half a second without: what does not hold."""
    wrong = []
    before = registers(machine, host)
    for fault in ("sda_low", "scl_low", "arlo", "berr", "nack"):
        machine.i2c[1].fault = fault
        run(machine, 0.5)
        during = registers(machine, host)
        machine.i2c[1].fault = None
        run(machine, 0.5)
        after = registers(machine, host)
        if during["rail_health"] != (3, 3, 3, 3) or after["rail_health"] != (0, 0, 0, 0):
            wrong.append(f"{fault}: rails {during['rail_health']}, then {after['rail_health']}")
        recovered = during["bus_recoveries"] - before["bus_recoveries"]
        # A sensor that does not acknowledge is no reason to set the bus up again.
        if (recovered == 0) != (fault == "nack"):
            wrong.append(f"{fault}: {recovered} recoveries")
        before = after
    # A sensor may go in the middle of a transaction, between its address and the repeated one: anywhere in a sample's period.
    for phase in range(0, 5000, SWITCH_OUT_US):
        next_sample = machine.now() // (5 * MS) * 5 * MS + 5 * MS + phase * (MS // 1000)
        run(machine, (next_sample - machine.now()) / PS)
        machine.i2c[1].fault = "nack"
        run(machine, 0.003)
        machine.i2c[1].fault = None
        run(machine, 0.005)
    after = registers(machine, host)
    recovered = after["bus_recoveries"] - before["bus_recoveries"]
    if recovered:
        wrong.append(f"sensors that go within a transaction: {recovered} recoveries")
    for name in ("missed_deadlines", "servo_timeouts", "link_broken"):
        if after[name]:
            wrong.append(f"{name}: {after[name]}")
    return wrong


def check(arguments, machine, before, after, recorder, host):
    """What does not hold, in words."""
    wrong = []

    def expect(holds, what):
        if not holds:
            wrong.append(what)

    expect(after["table_version"] == 5, f"table version {after['table_version']}")
    estimates = not arguments.silent_servo
    if estimates:
        state = [after[name] for name in ("upload_state", "coefficients_state", "model")]
        expect(state == [2, 0, 2], f"coefficients: {state}")
    seconds = (after["uptime_us"] - before["uptime_us"]) / 1e6
    rate = (after["samples"] - before["samples"]) / seconds
    # One sample more or less at the ends.
    expect(abs(rate - RATE) * seconds <= 1.01, f"{rate:.3f} samples a second")
    absent = [i for i, address in enumerate(RAILS) if address in arguments.absent]
    for name in ("missed_deadlines", "servo_timeouts", "servo_broken", "bus_recoveries", "link_broken", "fifo_lost"):
        expect(after[name] == 0, f"{name}: {after[name]}")
    silent = sum(after["rail_counters"][5 * i + 3] for i in absent)
    expect(after["bus_errors"] == silent, f"bus_errors: {after['bus_errors']}, {silent} of them absent sensors")
    expect(host.broken == 0, f"{host.broken} broken answers")
    expect(list(after["rail_health"]) == [3 if i in absent else 0 for i in range(4)], f"rails: {after['rail_health']}")
    expect(after["wheel_health"] == (0, 0), f"wheels: {after['wheel_health']}")
    for i, (shunt, bus) in enumerate(RAILS.values()):
        power = shunt * 10e-6 / 0.1 * bus * 4e-3
        found = after["rail_power"][i]
        expect(math.isnan(found) if i in absent else abs(found / power - 1) < 1e-5, f"rail {i}: {found} W for {power}")
    stats = {k: machine.dxl.stats[k] for k in ("bad", "dir_low", "wrong_baud", "unpowered")}
    expect(not any(stats.values()), f"servo bus: {stats}")
    expect(not machine.resets, f"resets: {machine.resets}")

    records = [record for record in recorder.records if record[1] >= before["uptime_us"]]
    expect(len(records) > RATE * (arguments.seconds - 0.2), f"{len(records)} records")
    whole = 1 | sum(2 << i for i in range(4) if i not in absent)
    for last, now in zip(records, records[1:]):
        if now[0] != last[0] + 1 or not 4000 < now[1] - last[1] < 6000:
            wrong.append(f"record {now[0]} at {now[1]} us after {last[0]} at {last[1]} us")
            break
    # Reading back a sensor's set-up, ten times a second, costs no reading.
    incomplete = [r[0] for r in records if r[9] & whole != whole]
    expect(not incomplete, f"{len(incomplete)} records without wheels or rails, the first {incomplete[:1]}")
    if estimates:
        # Has coefficients, and the estimator took the sample.
        expect(all(r[9] & 0xC0 == 0xC0 for r in records), "records without an estimate")
        # At a time constant of 0.05 s they have their speed after half a second.
        steady = records[RATE // 2 :]
        mean = [sum(r[2 + w] for r in steady) / max(1, len(steady)) for w in range(2)]
        wanted = [goal * 0.229 * 2 * math.pi / 60 for goal in GOALS]
        expect(all(abs(m / w - 1) < 0.01 for m, w in zip(mean, wanted)), f"wheels at {mean} rad/s for {wanted}")
    return wrong


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("image")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--absent", type=lambda text: int(text, 0), action="append", default=[])
    parser.add_argument("--silent-servo", type=int, action="append", default=[])
    parser.add_argument("--bus-faults", action="store_true")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--terminal", metavar="LINK")
    arguments = parser.parse_args()

    machine = set_up(arguments)
    if arguments.terminal:
        stop_and_go(machine)
        ptylink.serve(machine, arguments.seconds, link=arguments.terminal)
        return
    host = Host(machine)
    try:
        run(machine, SETTLED_S)
        upload(machine, host)
        turn(machine)
        run(machine, 0.5)
        before = registers(machine, host)
        recorder = Recorder(machine, host)
        run(machine, arguments.seconds)
        after = registers(machine, host)
    except Fault as fault:
        print(machine.backtrace())
        raise SystemExit(f"the core faulted: {fault}")
    wrong = check(arguments, machine, before, after, recorder, host)
    if arguments.bus_faults:
        wrong += disturb(machine, host)
    figures = {
        "seconds": arguments.seconds,
        "samples": after["samples"],
        "records": len(recorder.records),
        "missed_deadlines": after["missed_deadlines"],
        "bus_errors": after["bus_errors"],
        "idle_percent": round(100 * machine.sleep_ps / machine.now(), 1),
        "stack_bytes": stack_bytes(machine),
        "wrong": wrong,
    }
    print(json.dumps(figures) if arguments.json else "\n".join(f"{k}: {v}" for k, v in figures.items()))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()

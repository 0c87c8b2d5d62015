"""Faults of every bus, cable and supply, on the OpenCR image in the emulated STM32F746, while it drives: a table.

    PYTHONPATH=folder/of/emu emu opencr_faults.py IMAGE [--only WORD] [--json]

Each fault lasts for half a second, or happens once, in a robot that drives at 0.1 m/s; then everything is well again for a second and a
half. Of each: the samples taken in the fault's second, whether anything shown was stale, after how long all is as before, what the
board's clock lost against the chip's, and what was counted.
The emulator has no window watchdog: one is added here, which resets the chip as the manual says.
"""
import argparse
import json
import struct
import sys

import board
import periph
from board import MS, PS, Fault, Reset, reboot
from opencr_emulated import Host, Node, set_up
from protocol import packet

DRIVE = (10, 0)
GOALS = (126, 126)
BLOCK = 512, 320  # our registers up to the counters
EXTRA = 2328, 52
UPTIME = 548, 8
LEAST_SAMPLES = 195
RECOVERED_S = 1.0
# Of the chip's own time, over a fault.
MOST_CLOCK_S = 1e-3


class Watchdog(periph.P):
    """WWDG (RM0385): counts the slower bus's clock by 4096 · 8, and resets the chip below 64."""

    name = "WWDG"

    def __init__(self, m):
        super().__init__(m)
        self.event = None

    def write(self, offset, value):
        self.r[offset] = value
        if offset == 0 and value & 0x80:
            ticks = (value & 0x7F) - 0x3F
            self.m.cancel(self.event)
            self.event = self.m.after(int(ticks * 4096 * 8 * PS / self.m.rcc.pclk1), self.bite)

    def bite(self):
        # The emulator stands still while it erases: the board's code, which is in RAM, would go on feeding.
        erases = self.m.flash_if.erases
        if erases and self.m.now() - erases[-1][0] < 400 * MS:
            return
        self.m.st.limit = 0
        raise Reset("WWDG")


def add_watchdog(machine):
    machine.watchdog = Watchdog(machine)
    machine.map(0x40002C00, machine.watchdog)


def run(machine, seconds):
    end = machine.now() + int(seconds * PS)
    while machine.now() < end:
        try:
            machine.run_until(end)
        except (Reset, Fault) as what:
            cause = str(what)
            if isinstance(what, Fault):
                # The core has locked up: nothing more is executed until the watchdog's time is over.
                cause = "WWDG"
                machine.stall(39 * MS)
            machine.supply_at_reset = machine.gpio["F"].out(15)
            reboot(machine, "SYSRESETREQ" if cause == "WWDG" else cause)
            if cause == "WWDG":
                machine.resets[-1] = (machine.resets[-1][0], "WWDG")
                machine.rcc.r[0x74] = 0x44000000
            add_watchdog(machine)


class Robot:
    def __init__(self, image):
        arguments = argparse.Namespace(image=image, absent=[], silent_servo=[])
        self.machine = set_up(arguments)
        add_watchdog(self.machine)
        self.host = Host(self.machine)
        run(self.machine, 1.2)
        self.node = Node(self.machine)
        self.drive()
        run(self.machine, 1.0)

    def drive(self):
        """Commands again and again, as a planner does."""
        self.node.command(*DRIVE)
        self.machine.after(100 * MS, self.drive, keep=True)

    def look(self, limit=0.3):
        """All registers, or None where the board does not answer."""
        found = {}
        self.host.waiting.clear()
        self.host.bytes.clear()
        self.host.read(*BLOCK, lambda data: found.update(block=data))
        self.host.read(*EXTRA, lambda data: found.update(extra=data))
        waited = 0.0
        while waited < limit and "extra" not in found:
            run(self.machine, 0.005)
            waited += 0.005
        if "extra" not in found:
            return None
        at = lambda form, address: struct.unpack_from("<" + form, found["block"], address - BLOCK[0])
        more = lambda form, address: struct.unpack_from("<" + form, found["extra"], address - EXTRA[0])
        return {
            "uptime": at("Q", 548)[0] / 1e6,
            "rails": at("4B", 620),
            "power": at("4f", 556),
            "wheels": at("2B", 720),
            "samples": at("I", 792)[0],
            "late": at("I", 796)[0],
            "timeouts": at("I", 800)[0],
            "broken": at("I", 804)[0],
            "bus_errors": at("I", 808)[0],
            "recoveries": at("I", 812)[0],
            "state": more("B", 2329)[0],
            "cause": more("B", 2328)[0],
            "resets": more("I", 2336)[0],
            "goals": more("2i", 2340),
            "unverified": more("I", 2364)[0],
            "tripped": more("I", 2368)[0],
            "restarts": more("I", 2372)[0],
            "abandoned": more("I", 2376)[0],
        }

    def clock(self):
        """How far the board's clock is behind the chip's time, s: the least of some looks, each of which is older by its answer's way."""
        behind = []
        self.host.waiting.clear()
        self.host.bytes.clear()
        for _ in range(40):
            self.host.read(*UPTIME, lambda data: behind.append(self.machine.now() / PS - struct.unpack("<Q", data)[0] / 1e6))
            run(self.machine, 0.0017)
        return min(behind) if behind else None

    def is_well(self, seen):
        turning = all(abs(servo.g(104, 4) - goal) <= 1 for servo, goal in zip(self.machine.servos, GOALS))
        return seen is not None and seen["rails"] == (0,) * 4 and seen["wheels"] == (0, 0) and turning


def servo_restart(robot, index):
    servo = robot.machine.servos[index]
    servo.sync()
    servo.t[64:68] = bytes(4)
    servo.t[98:126] = bytes(28)
    servo.pos %= 4096


def overload(robot):
    servo = robot.machine.servos[0]
    servo.t[70], servo.t[64], servo.err_bit = 0x20, 0, 0x80


def recover_from_overload(robot):
    """As somebody does: torque off and on again."""
    robot.node.write(149, b"\0")
    robot.machine.after(200 * MS, lambda: robot.node.write(149, b"\1"), keep=True)


def framing(robot):
    robot.machine.usart["USART3"].send(b"\x55\xaa", flags=2, gate=lambda: robot.machine.dxl.dir() == 0)


def flood(robot, data, megabytes_s):
    """Bytes without end on the node's port for half a second."""
    machine, end = robot.machine, robot.machine.now() + 500 * MS
    pause = int(64 / (megabytes_s * 1e6) * PS)

    def more():
        machine.otg.tok_out(Node.OUT, data)
        if machine.now() < end:
            machine.after(pause, more, keep=True)

    more()


def unplug(robot):
    host = robot.machine.host
    robot.host.waiting.clear()
    host.unplugged()
    robot.machine.after(400 * MS, host.busreset, keep=True)


def unplug_in_answer(packets):
    def act(robot):
        robot.host.ask(request(1368, 960), lambda _: None)
        seen = len(robot.machine.host.rx_packets)
        for _ in range(400):
            run(robot.machine, 0.00005)
            if len(robot.machine.host.rx_packets) - seen >= packets:
                break
        unplug(robot)

    return act


def request(address, length):
    return packet(2, struct.pack("<HH", address, length))


def call(robot, number):
    """An interrupt that nobody handles."""
    robot.machine.scs.write(0xE000E100 + 4 * (number // 32), 1 << number % 32)
    robot.machine.set_pending(16 + number)


def overflow(robot):
    """The stack pointer below the stack's memory: the next push faults, and so does the handler."""
    import unicorn.arm_const as arm

    robot.machine.uc.reg_write(arm.UC_ARM_REG_SP, 0x20000000 - 0x100)


def i2c(fault):
    return lambda robot: setattr(robot.machine.i2c[1], "fault", fault), lambda robot: setattr(robot.machine.i2c[1], "fault", None)


def servos(indices, alive):
    def act(robot):
        for index in indices:
            robot.machine.servos[index].alive = alive

    return act


def bus(name, value, after=None):
    begin = lambda robot: setattr(robot.machine.dxl, name, value)
    return begin, (lambda robot: setattr(robot.machine.dxl, name, after)) if after is not None else None


def present(value):
    return lambda robot: setattr(robot.machine.i2c[1].devs[0x44], "present", value)


# Name: what begins it, what ends it, and whether a reset is what should come of it.
FAULTS = {
    "SCL low": (*i2c("scl_low"), False),
    "SDA low": (*i2c("sda_low"), False),
    "arbitration lost": (*i2c("arlo"), False),
    "bus error": (*i2c("berr"), False),
    "no acknowledge": (*i2c("nack"), False),
    "absent sensor": (present(False), present(True), False),
    "brown-out of a sensor": (lambda robot: robot.machine.i2c[1].devs[0x44].brownout(), None, False),
    "servo packets dropped": (*bus("drop_next", 5), False),
    "servo packets corrupted": (*bus("corrupt_next", 5), False),
    "servo answers late": (*bus("extra_delay", 2 * MS, 0), False),
    "framing error": (framing, None, False),
    "left servo dead": (servos([0], False), servos([0], True), False),
    "both servos dead": (servos([0, 1], False), servos([0, 1], True), False),
    "left servo restarts": (lambda robot: servo_restart(robot, 0), None, False),
    "both servos lose power": (lambda robot: [servo_restart(robot, i) for i in (0, 1)], None, False),
    "overload of a servo": (overload, recover_from_overload, False),
    "USB unplugged": (unplug, None, False),
    "USB unplugged in an answer, packet 0": (unplug_in_answer(0), None, False),
    "USB unplugged in an answer, packet 5": (unplug_in_answer(5), None, False),
    "USB unplugged in an answer, packet 14": (unplug_in_answer(14), None, False),
    "flood of headers, 1.2 MB/s": (lambda robot: flood(robot, b"\xff\xff\xfd\x00" * 16, 1.2), None, False),
    "flood of noise, 1.2 MB/s": (lambda robot: flood(robot, bytes(range(64)), 1.2), None, False),
    "flood of pings, 0.5 MB/s": (lambda robot: flood(robot, bytes.fromhex("fffffd00c80300013bfa") * 6, 0.5), None, False),
    "interrupt without a handler": (lambda robot: call(robot, 80), None, True),
    "non-maskable interrupt": (lambda robot: robot.machine.set_pending(2), None, True),
    "stack overflow": (overflow, None, True),
}


def row(robot, name):
    begin, end, is_reset = FAULTS[name]
    before, clock = robot.look(), robot.clock()
    resets = len(robot.machine.resets)
    begin(robot)
    run(robot.machine, 0.5)
    during = robot.look(0.1)
    if end:
        end(robot)
    ended = robot.machine.now()
    recovered = None
    while robot.machine.now() - ended < 4 * PS:
        after = robot.look()
        if robot.is_well(after):
            recovered = (robot.machine.now() - ended) / PS
            break
        run(robot.machine, 0.02)
    if after is None:
        return {"fault": name, "samples_s": None, "recovered_s": None, "counted": "does not answer", "wrong": ["does not answer"]}
    # Rails that are not well show no power.
    stale = during is not None and any(h == 3 and p == p for h, p in zip(during["rails"], during["power"]))
    seconds = after["uptime"] - before["uptime"]
    has_reset = len(robot.machine.resets) > resets
    rate = None if has_reset else (after["samples"] - before["samples"]) / seconds
    names = ("late", "timeouts", "broken", "bus_errors", "recoveries", "unverified", "tripped", "restarts", "abandoned", "resets")
    counted = {key: after[key] - before[key] for key in names if after[key] != before[key]}
    wrong = []
    if has_reset != is_reset:
        wrong.append(f"resets: {robot.machine.resets[resets:]}")
    if is_reset and after["resets"] != before["resets"] + 1:
        wrong.append(f"reset not counted: {after['resets']}")
    # Where a handler still runs it cuts the supply; where the core hangs, the reset of its pins does.
    if has_reset and robot.machine.resets[-1][1] != "WWDG" and robot.machine.supply_at_reset:
        wrong.append("motors not cut off")
    if rate is not None and rate < LEAST_SAMPLES:
        wrong.append(f"{rate:.1f} samples a second")
    if stale:
        wrong.append("something stale is shown")
    lost = None
    if not has_reset and None not in (clock, later := robot.clock()):
        lost = later - clock
        if abs(lost) > MOST_CLOCK_S:
            wrong.append(f"the clock lost {1e3 * lost:.2f} ms")
    limit = RECOVERED_S + (1.5 if is_reset or "overload" in name else 0)
    if recovered is None or recovered > limit:
        wrong.append(f"recovered after {recovered} s")
    counted["cause"] = after["cause"]
    return {"fault": name, "samples_s": rate and round(rate, 1), "recovered_s": recovered and round(recovered, 2),
            "clock_ms": lost and round(1e3 * lost, 3), "counted": counted, "wrong": wrong}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("image")
    parser.add_argument("--only", default="")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    robot, rows = None, []
    for name in FAULTS:
        if arguments.only not in name:
            continue
        if robot is None:
            robot = Robot(arguments.image)
            if not robot.is_well(robot.look()):
                raise SystemExit(f"does not drive: {robot.look()}")
        found = row(robot, name)
        rows.append(found)
        if not arguments.json:
            print(f"{found['fault']:38} {found['samples_s']!s:>6}/s  {found['recovered_s']!s:>5} s  {found.get('clock_ms')!s:>6} ms  {found['counted']}  {found['wrong'] or ''}", flush=True)
        if found["wrong"]:
            # Whatever is left of it is not the next one's.
            robot = None
        else:
            run(robot.machine, 0.5)
    if arguments.json:
        print(json.dumps(rows))
    sys.exit(1 if any(found["wrong"] for found in rows) else 0)


if __name__ == "__main__":
    main()

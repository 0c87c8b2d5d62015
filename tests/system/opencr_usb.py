"""A USB host that leaves control transfers unfinished, floods the board and breaks the bus's rules, on the OpenCR image in the emulated
STM32F746: after each the next control transfer is answered, a bus reset brings the link back, and the board never restarts.

    PYTHONPATH=folder/of/emu emu opencr_usb.py IMAGE [--only WORD] [--json]
"""
import argparse
import json
import struct
import sys

from board import MS, PS, US, Fault, Reset
from opencr_emulated import Host, set_up
from opencr_faults import add_watchdog
from protocol import packet

# From the end of what is done to the board to its first answer, with what the host takes for enumerating. The reset itself takes 20 ms.
MOST_BACK_S = 0.2

# Token, data and handshake at 12 Mbit/s, 165 bits with their pauses (USB 2.0, 8.4): no host is faster.
SETUP_US = 14

GET_DEVICE = 0x80, 6, 0x100, 0, 18
GET_CONFIGURATION = 0x80, 6, 0x200, 0, 255
SET_LINE_CODING = 0x21, 0x20, 0, 0, 7
SET_CONFIGURATION = 0, 9, 1, 0, 0
SET_ADDRESS = 0, 5, 7, 0, 0
HALT, CLEAR_HALT, STATUS = (2, 3, 0), (2, 1, 0), (0x82, 0, 0)


def run(machine, seconds):
    end = machine.now() + int(seconds * PS)
    while machine.now() < end:
        machine.run_until(end)


def setup(usb, request, length=8):
    """A SETUP packet of so many bytes. The core reports it in two entries of its FIFO (RM0385, OTG_GRXSTSP)."""
    data = (struct.pack("<BBHHH", *request) * 9)[:length]
    for control in (usb.outctl, usb.inctl):
        control[0] = (control[0] | 1 << 17) & ~(1 << 21)
    usb.rxq.append((length << 4 | 6 << 17, usb.words(data)))
    usb.rxq.append((4 << 17, []))
    usb.upd()


def once(request, length=8):
    return lambda robot: setup(robot.usb, request, length)


def fetched_without_status(robot):
    setup(robot.usb, GET_DEVICE)
    run(robot.machine, 0.001)
    robot.usb.tok_in(0)


def flood(request, pause_us, length=8):
    """For a tenth of a second, each as if the one before had never been."""

    def act(robot):
        end = robot.machine.now() + 100 * MS
        while robot.machine.now() < end:
            if len(robot.usb.rxq) < 16:
                setup(robot.usb, request, length)
            run(robot.machine, pause_us * US / PS)

    return act


def bounce(robot):
    """A cable that makes and breaks contact while the host enumerates: resets within transfers."""
    for request in (GET_DEVICE, SET_ADDRESS, GET_CONFIGURATION, SET_CONFIGURATION, SET_LINE_CODING):
        for wait_us in (0, 30, 300):
            setup(robot.usb, request)
            run(robot.machine, wait_us * US / PS)
            robot.usb.sts |= 1 << 12
            robot.usb.upd()
            run(robot.machine, 0.002)


def within_an_answer(robot):
    """Of 960 bytes, of which the host fetches some packets and no more."""
    robot.host.write(packet(2, struct.pack("<HH", 1368, 960)))
    run(robot.machine, 0.0007)
    robot.host.bulk = False
    run(robot.machine, 0.001)


def endpoints(kind, length):
    """To every endpoint that a request can name, of which the chip has six."""

    def act(robot):
        for direction in (0, 0x80):
            for number in range(1, 16):
                setup(robot.usb, (*kind, direction | number, length))
                run(robot.machine, 0.0005)
                robot.usb.tok_in(0)
                run(robot.machine, 0.0005)

    return act


HOSTILE = {
    "GET_DESCRIPTOR, never fetched": once(GET_DEVICE),
    "a long GET_DESCRIPTOR, never fetched": once(GET_CONFIGURATION),
    "GET_DESCRIPTOR without a status stage": fetched_without_status,
    "SET_LINE_CODING without data": once(SET_LINE_CODING),
    "SET_ADDRESS without a status stage": once(SET_ADDRESS),
    "SET_CONFIGURATION without a status stage": once(SET_CONFIGURATION),
    "a flood of GET_DESCRIPTOR": flood(GET_CONFIGURATION, 20),
    "a flood of SET_LINE_CODING": flood(SET_LINE_CODING, 20),
    "a flood of SET_ADDRESS, as fast as the bus is": flood(SET_ADDRESS, SETUP_US),
    "SETUP of 0 bytes": once(GET_DEVICE, 0),
    "SETUP of 7 bytes": once(GET_DEVICE, 7),
    "SETUP of 9 bytes": once(GET_DEVICE, 9),
    "SETUP of 64 bytes": once(GET_DEVICE, 64),
    "SETUP of 72 bytes": once(GET_DEVICE, 72),
    "a flood of SETUP of 7 bytes": flood(GET_DEVICE, 20, 7),
    "halts of endpoints that are not there": endpoints(HALT, 0),
    "halts that are taken back": endpoints(CLEAR_HALT, 0),
    "status of endpoints that are not there": endpoints(STATUS, 2),
    "a bouncing cable": bounce,
    "a reset within an answer": within_an_answer,
}


class Robot:
    def __init__(self, image):
        self.machine = set_up(argparse.Namespace(image=image, absent=[], silent_servo=[]))
        add_watchdog(self.machine)
        self.asks = Host(self.machine)
        run(self.machine, 1.2)

    @property
    def host(self):
        return self.machine.host

    @property
    def usb(self):
        return self.machine.otg

    def answers_within(self, seconds):
        """After how long it answers a question, s; None where it does not."""
        began, found = self.machine.now(), []
        self.asks.waiting.clear()
        self.asks.bytes.clear()
        while not found and self.machine.now() - began < seconds * PS:
            if self.host.bulk and not self.asks.waiting:
                self.asks.read(0, 2, found.append)
            run(self.machine, 0.0005)
        return (self.machine.now() - began) / PS if found else None

    def control(self, *request):
        """A whole control transfer, as the emulator's host makes them: what the board sends, or how it ends."""
        transfer = self.host.control(*request)
        while True:
            try:
                run(self.machine, next(transfer) / PS)
            except StopIteration as end:
                return end.value

    def reset_bus(self):
        self.host.unplugged()
        self.host.busreset()


def row(robot, name):
    wrong = []
    if robot.answers_within(0.1) is None:
        return {"hostile": name, "back_s": None, "wrong": ["does not answer before"]}
    robot.host.bulk = False
    HOSTILE[name](robot)
    run(robot.machine, 0.05)
    descriptor = robot.control(*GET_DEVICE)
    if not isinstance(descriptor, bytes) or len(descriptor) != 18:
        wrong.append(f"to the next request: {descriptor}")
    robot.reset_bus()
    back = robot.answers_within(2.0)
    if back is None or back > MOST_BACK_S:
        wrong.append(f"back after {back} s")
    return {"hostile": name, "back_s": back and round(back, 3), "wrong": wrong}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("image")
    parser.add_argument("--only", default="")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    robot, rows = None, []
    for name in HOSTILE:
        if arguments.only not in name:
            continue
        robot = robot or Robot(arguments.image)
        try:
            found = row(robot, name)
        except (Reset, Fault) as what:
            found = {"hostile": name, "back_s": None, "wrong": [f"the board restarts: {what}"]}
        except TypeError:
            # The emulator's host takes what it did not get for a descriptor.
            found = {"hostile": name, "back_s": None, "wrong": ["it is not found on the bus"]}
        rows.append(found)
        if not arguments.json:
            print(f"{found['hostile']:44} {found['back_s']!s:>6} s  {found['wrong'] or ''}", flush=True)
        if found["wrong"]:
            robot = None
    if arguments.json:
        print(json.dumps(rows))
    sys.exit(1 if any(found["wrong"] for found in rows) else 0)


if __name__ == "__main__":
    main()

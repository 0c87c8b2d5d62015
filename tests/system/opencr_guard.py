"""A stop between two samples while an upload is about to be written, on the OpenCR image in the emulated STM32F746: no word of the flash, which stops the
core, is written while a packet is on the servos' bus.

    PYTHONPATH=folder/of/emu emu opencr_guard.py IMAGE [--every US]

The wheels are held: they stand with a goal, so that the flash may be written, and the heartbeat ends just before it is. A first run says when that
is; each of the others ends the heartbeat a little earlier, so that the stop's packet, of 0.2 ms, begins at every place before the write.
"""
import argparse
import json
import struct
import sys

from board import MS, PS, US, run
from opencr_emulated import UPLOAD_ITEM, UPLOAD_WINDOW, Host, Node, coefficients, set_up
from protocol import packet

DRIVE = struct.pack("<6i", 6, 0, 0, 0, 0, 0)
UPLOAD_S, END_S = 3.0, 3.6
HEARTBEAT_MS = 500
# A packet of two goals takes 220 us, the board takes a heartbeat some 0.1 ms after the host has sent it, and it prepares for a millisecond
# at most before it writes.
FIRST_US, LAST_US = -150, 1350


def stand(servo):
    """Whatever its goal is, it does not turn."""
    move = servo.sync

    def sync():
        move()
        servo.vel, servo.pos = 0.0, 2048.0
        servo.t[128:136] = struct.pack("<2i", 0, 2048)

    servo.sync = sync


def written(image, last_beat):
    """When words were written to the flash after the upload, and which of them while a packet was on the bus."""
    machine = set_up(argparse.Namespace(image=image, absent=[], silent_servo=[]))
    for servo in machine.servos:
        stand(servo)
    host, node = Host(machine), Node(machine)
    store, times, within = machine.on_flash_write, [], []

    def word(address, size, value):
        if machine.now() > UPLOAD_S * PS:
            times.append(machine.now())
            if machine.gpio["C"].out(9) == 1:
                within.append(machine.now())
        return store(address, size, value)

    machine.on_flash_write = word

    def command():
        if node.lives:
            node.write(150, DRIVE)
        machine.after(100 * MS, command, keep=True)

    command()
    if last_beat:
        def end():
            node.lives = False
            node.queue.clear()
            node.count = (node.count + 1) % 256
            machine.otg.tok_out(Node.OUT, packet(3, struct.pack("<HB", 19, node.count)))

        machine.after(last_beat - machine.now(), end, keep=True)
    image_ = coefficients()
    run(machine, UPLOAD_S - machine.now() / PS)
    host.write(UPLOAD_WINDOW, image_)
    host.write(UPLOAD_ITEM, struct.pack("<BBH", 1, 1, len(image_)))
    run(machine, END_S - machine.now() / PS)
    stops = [when for when, who, what, data in machine.dxl.inst_log if what == 0x83 and not any(data[5:9])]
    return times, within, stops


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("image")
    parser.add_argument("--every", type=int, default=100, metavar="US", help="between two places")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    steps = range(FIRST_US, LAST_US, arguments.every)
    times, _, _ = written(arguments.image, None)
    if not times:
        raise SystemExit("nothing was written")
    wrong, near = [], 0
    for step in steps:
        beat = times[0] - HEARTBEAT_MS * MS - step * US
        found, within, stops = written(arguments.image, beat)
        near += any(abs(stop - times[0]) < 6 * MS for stop in stops)
        if within:
            wrong.append(f"{step} us before: {len(within)} words while a packet was on the bus")
    if not near:
        wrong.append("no stop came near a write")
    figures = {"runs": len(steps), "stops_near_a_write": near, "wrong": wrong}
    print(json.dumps(figures) if arguments.json else "\n".join(f"{key}: {value}" for key, value in figures.items()))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()

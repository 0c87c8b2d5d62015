"""Cuts the power of the emulated OpenCR while it stores coefficients: behind every cut the old ones are in use or the new ones.

    PYTHONPATH=folder/of/emu emu opencr_cuts.py IMAGE [--cuts 1000] [--seed 1] [--json]

Every round boots the real image on the flash that the round before left, uploads coefficients that differ from those in use, and takes
the power away at a write to the flash that is drawn from the seed: the word that is being written is left with some of its bits, the
RAM with noise. What a round checks after the next boot stands in `judge`. Rounds that came to their end without a cut are counted too.
Ctrl-C ends it behind the round under way, with what it has found so far.
"""
import argparse
import json
import random
import signal
import struct
import sys
import zlib

from board import Fault, Reset, reboot, run
from opencr_emulated import SETTLED_S, STORED_S, UPLOAD_ITEM, UPLOAD_WINDOW, Host, coefficients, set_up

COEFFICIENTS_STATE, COEFFICIENTS_CRC = 519, 520
RAM = 0x20000000, 0x50000
# Writes to the flash that one upload makes, about; where the cut comes later there is none.
WRITES = 120


def image(density):
    """Coefficients that differ by their noise alone."""
    body = bytearray(coefficients()[:-4])
    body[60:64] = struct.pack("<f", density)
    return bytes(body) + struct.pack("<I", zlib.crc32(body))


class Cutter:
    """Takes the power away at the n-th write from now on."""

    def __init__(self, machine, generator):
        self.machine, self.generator, self.left, self.torn = machine, generator, None, None
        self.program = None

    def arm(self, writes):
        # A reset builds the peripherals anew.
        self.program = self.machine.flash_if.prog
        self.machine.on_flash_write = self.write
        self.left, self.torn = writes, None

    def write(self, address, size, value):
        self.program(address, size, value)
        if self.left is None or self.torn is not None:
            return
        self.left -= 1
        if self.left == 0:
            before = int.from_bytes(self.machine.uc.mem_read(address, size), "little")
            # Flash only clears bits: those of the word that the time was enough for.
            self.torn = address, size, before & (value | self.generator.getrandbits(8 * size))
            self.machine.extra_stop = Reset("PIN")
            self.machine.st.limit = 0

    def boot(self):
        """What the cut leaves: a torn word, and noise in the RAM."""
        machine = self.machine
        if self.torn is not None:
            address, size, value = self.torn
            machine.uc.mem_write(address, value.to_bytes(size, "little"))
        machine.uc.mem_write(RAM[0], self.generator.randbytes(RAM[1]))
        machine.extra_stop = None
        reboot(machine, "PIN")


def judge(machine, host, allowed):
    """What is wrong behind a boot, and the checksum of the coefficients in use (0: none)."""
    found = {}
    host.read(COEFFICIENTS_STATE, 5, lambda data: found.update(state=data[0], crc=struct.unpack("<I", data[1:5])[0]))
    run(machine, 0.2)
    if not found:
        return "the board does not answer on its link", None
    if found["crc"] not in allowed:
        return f"coefficients {found['crc']:08x}, state {found['state']}; expected of {[f'{crc:08x}' for crc in allowed]}", None
    if found["crc"] and found["state"]:
        return f"coefficients in use, and state {found['state']}", None
    return None, found["crc"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("image")
    parser.add_argument("--cuts", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    arguments.absent, arguments.silent_servo = [], []
    generator = random.Random(arguments.seed)
    machine = set_up(arguments)
    cutter = Cutter(machine, generator)
    host, in_use, wrong = Host(machine), 0, []
    cuts = whole = old = new = rounds = 0
    stopping = []
    # An exception would get lost in the emulator's calls back.
    signal.signal(signal.SIGINT, lambda *_: stopping.append(True))
    try:
        run(machine, SETTLED_S)
        while cuts < arguments.cuts and len(wrong) < 10 and not stopping:
            rounds += 1
            upload = image(0.003 + 1e-6 * rounds)
            crc = struct.unpack("<I", upload[-4:])[0]
            cutter.arm(generator.randint(1, WRITES))
            host.write(UPLOAD_WINDOW, upload)
            host.write(UPLOAD_ITEM, struct.pack("<BBH", 1, 1, len(upload)))
            try:
                run(machine, STORED_S, on_reset="raise")
                cutter.left = None
                whole += 1
            except Reset as reset:
                if cutter.torn is None:
                    wrong.append(f"round {rounds}: the board reset by itself: {reset}")
                cuts += 1
            cutter.boot()
            host = Host(machine)
            run(machine, SETTLED_S)
            why, now = judge(machine, host, (in_use, crc))
            if why:
                wrong.append(f"round {rounds}: {why}")
                break
            old, new = old + (now == in_use), new + (now == crc)
            in_use = now
    except Fault as fault:
        print(machine.backtrace())
        raise SystemExit(f"round {rounds}: the core faulted: {fault}")
    figures = {"cuts": cuts, "whole": whole, "old_in_use": old, "new_in_use": new, "wrong": wrong}
    print(json.dumps(figures) if arguments.json else "\n".join(f"{k}: {v}" for k, v in figures.items()))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()

"""Flipped bits on the power sensors' bus of the OpenCR image in the emulated STM32F746: whatever a record then calls a power is one.

    PYTHONPATH=folder/of/emu emu opencr_flips.py IMAGE [--seconds S] [--rate R] [--json]

Every byte on the bus, either way, has each bit flipped with the probability `--rate`; addresses and registers too. The sensors are those of the
datasheet (SBOS448G): they convert when told to, keep what they converted, and clip at the range that they are set to.
"""
import argparse
import json
import random
import sys

from board import PS, run
from opencr_emulated import RAILS, SETTLED_S, Host, Recorder, registers, set_up

MOST_OFF = 0.01
# Conversions that end between a sensor's poll and the next one.
CONVERSION_S = 4.256e-3
FULL_SCALE = 4000


class Sensor:
    """An INA219: triggered and continuous conversions, ranges, its product."""

    def __init__(self, machine, shunt, bus):
        self.machine, self.true = machine, (shunt, bus)
        self.pointer, self.count, self.bytes = 0, 0, []
        self.reset()

    def reset(self):
        self.configuration, self.calibration, self.seen, self.ready = 0x399F, 0, (0, 0), False
        self.begun = self.machine.now()

    def convert(self):
        """What has been converted until now: means as they are set take longer or shorter, which nothing here hangs on."""
        if self.configuration & 3 == 3 and self.begun is not None and self.machine.now() - self.begun >= CONVERSION_S * PS:
            limit = FULL_SCALE << (self.configuration >> 11 & 3)
            shunt, bus = self.true
            self.seen = max(-limit, min(limit, shunt)), min(bus, 8000 if self.configuration & 0x2000 else 4000)
            self.product = abs(self.seen[0] * self.calibration // 4096) * self.seen[1] // 5000 & 0xFFFF
            self.ready = True
            self.begun = self.machine.now() if self.configuration & 4 else None

    def start(self, reads):
        self.count = 0
        if reads:
            self.convert()
            value = {
                0: self.configuration,
                1: self.seen[0] & 0xFFFF,
                2: self.seen[1] << 3 | (2 if self.ready else 0),
                3: getattr(self, "product", 0),
                4: self.seen[0] * self.calibration // 4096 & 0xFFFF,
                5: self.calibration,
            }.get(self.pointer, 0)
            self.bytes = [value >> 8, value & 0xFF]
            if self.pointer == 3:
                self.ready = False
        return True

    def write(self, byte):
        self.convert()
        if self.count == 0:
            self.pointer = byte
        elif self.count == 1:
            self.high = byte
        elif self.count == 2:
            value = self.high << 8 | byte
            if self.pointer == 0 and value & 0x8000:
                self.reset()
            elif self.pointer == 0:
                self.configuration, self.ready, self.begun = value, False, self.machine.now()
            elif self.pointer == 5:
                self.calibration = value & 0xFFFE
        self.count += 1
        return True

    def read(self):
        return self.bytes.pop(0) if self.bytes else 0xFF

    def stop(self):
        pass


class Noisy:
    """A sensor behind wires that flip bits."""

    def __init__(self, sensor, random_, rate, flips):
        self.sensor, self.random, self.rate, self.flips = sensor, random_, rate, flips
        self.present = True

    def flip(self, byte):
        for bit in range(8):
            if self.random.random() < self.rate:
                byte ^= 1 << bit
                self.flips.append(byte)
        return byte

    def start(self, reads):
        return self.sensor.start(reads)

    def write(self, byte):
        return self.sensor.write(self.flip(byte))

    def read(self):
        return self.flip(self.sensor.read())

    def stop(self):
        self.sensor.stop()


class Devices(dict):
    """Addresses flip too: another sensor answers, or none."""

    def __init__(self, random_, rate, flips):
        super().__init__()
        self.random, self.rate, self.flips = random_, rate, flips

    def get(self, address, default=None):
        for bit in range(7):
            if self.random.random() < self.rate:
                address ^= 1 << bit
                self.flips.append(address)
        return super().get(address, default)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("image")
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--rate", type=float, default=1e-4)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    machine = set_up(argparse.Namespace(image=arguments.image, absent=[], silent_servo=[]))
    random_, flips = random.Random(4), []

    devices = Devices(random_, 0.0, flips)
    for address, (shunt, bus) in RAILS.items():
        devices[address] = Noisy(Sensor(machine, shunt, bus), random_, 0.0, flips)
    machine.i2c[1].devs = devices
    host = Host(machine)
    run(machine, SETTLED_S)
    before = registers(machine, host)
    devices.rate = arguments.rate
    for device in devices.values():
        device.rate = arguments.rate
    recorder = Recorder(machine, host)
    run(machine, arguments.seconds)
    after = registers(machine, host)
    records = [record for record in recorder.records if record[1] >= before["uptime_us"]]
    off, powers, left_out = [], 0, 0
    for record in records:
        for rail, (shunt, bus) in enumerate(RAILS.values()):
            if not record[9] & 2 << rail:
                left_out += 1
                continue
            powers += 1
            true = shunt * 10e-6 / 0.1 * bus * 4e-3
            error = record[4 + rail] / true - 1
            if abs(error) > MOST_OFF:
                off.append((record[0], rail, round(100 * error, 1)))
    wrong = []
    if off:
        wrong.append(f"{len(off)} of {powers} powers off by more than {100 * MOST_OFF:g} %: {off[:8]}")
    if not flips or not powers:
        wrong.append("nothing was flipped, or nothing measured")
    # Of every transaction with a flip one reading is lost, and of the set-up that follows one more.
    if left_out > 3 * len(flips) + 4:
        wrong.append(f"{left_out} readings left out for {len(flips)} flipped bits")
    if list(before["rail_health"]) != [0] * 4 or before["missed_deadlines"] != after["missed_deadlines"]:
        wrong.append(f"before: {before['rail_health']}, missed {after['missed_deadlines']}")
    figures = {"records": len(records), "flipped_bits": len(flips), "powers": powers, "left_out": left_out, "wrong": wrong}
    print(json.dumps(figures) if arguments.json else "\n".join(f"{key}: {value}" for key, value in figures.items()))
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()

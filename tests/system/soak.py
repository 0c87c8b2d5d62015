"""Hours of a virtual robot's life with faults at random times: are the board's estimates still true at the end?

    cargo build --release -p host-tools --bin gmr
    cargo build --release -p firmware --features virtual --bin virtual --target thumbv7em-none-eabihf
    python3 tests/system/soak.py GMR IMAGE [--hours 4] [--seed 1] [--folder DIR] [--wall-minutes M] [--json]

The board is taught as `cargo xtask demo` teaches it: two drives of 100 s, a fit, coefficients flashed. Then it drives by the test profile; the
payload changes every 200 to 600 s, and about once a minute a fault of `gmr board --faults` comes, of a kind, a place, a length and a time drawn
from the seed. A client reads the board's registers five times a board second and holds them against what the plant says was true:

- energy of each rail since the start, within 1 % at the end of a run of more than ten minutes (also its worst after these is printed);
- payload: total mass, median and 95 % of the error at all times more than a window after a change at which the board says it knows it; the median
  within 3 %; its 95 % interval holds the truth 93 to 97 % of that time, once an hour or more of it has been seen;
- actuation energy by measurement and by the model, within 1 % of the plant's at the end, over the time that the board says each counts (a fault leaves
  some of it out, and how much of the plant's energy that is, is printed);
- samples: 200 a second of the board's time.

At the end of the wall time asked for, it says how far it came.
"""
import argparse
import json
import math
import os
import random
import struct
import subprocess
import sys
import time
import tty

from protocol import answers, packet

WINDOW_S = 25.0
MOST_ERROR, MOST_ENERGY_ERROR = 0.03, 0.01
# Share of the time that a 95 % interval holds the truth. Masses a window apart are one: less time says nothing of two points in a hundred.
COVERED, COVERED_FROM_S = (0.93, 0.97), 3600.0
# Before, a single fault of 3 s is more than that.
SETTLED_S = 600
BLOCK = 512, 320
COUNTED_BLOCK = 2568, 8
RATE = 200
RAILS = ("battery", "motors", "computer", "lidar")
# What, how it is placed, and whether it lasts. A servo's overload needs somebody who switches torque off and on, which nobody does here.
FAULTS = (
    ("bus-stuck", None, True),
    ("sensor-absent", RAILS, True),
    ("sensor-brown-out", RAILS, False),
    ("sensor-silent", RAILS, False),
    ("servo-dead", ("left", "right"), True),
    ("servo-drop", ("left", "right"), False),
    ("servo-corrupt", ("left", "right"), False),
    ("servo-restart", ("left", "right"), False),
)
COUNTED = ("sensor-silent", "servo-drop", "servo-corrupt")


def faults(generator, seconds):
    """When they come, and a script: a fault a minute on average, of up to 3 s or 40 answers."""
    times, text, at = [], [], 30.0
    while (at := at + generator.expovariate(1 / 60)) < seconds - 10:
        what, places, lasts = generator.choice(FAULTS)
        times.append(at)
        lines = ["[[fault]]", f"at_s = {at:.3f}", f'what = "{what}"']
        if places:
            lines.append(f'which = "{generator.choice(places)}"')
        if lasts:
            length = generator.uniform(0.1, 3.0)
            lines.append(f"for_s = {length:.3f}")
            at += length
        if what in COUNTED:
            lines.append(f"count = {generator.randint(1, 40)}")
        text.append("\n".join(lines))
    return times, text


def payloads(generator, seconds):
    """Total mass, kg, in steps of KG@SECONDS."""
    steps, at = [], 0.0
    while at < seconds:
        steps.append((at, generator.uniform(1.0, 6.0)))
        at += generator.uniform(200, 600)
    return ",".join(f"{mass:.2f}@{at:.0f}" for at, mass in steps)


class Tools:
    def __init__(self, gmr, image, folder):
        self.gmr, self.image, self.folder = os.path.abspath(gmr), os.path.abspath(image), folder
        self.link = os.path.join(folder, "link")

    def run(self, *arguments):
        done = subprocess.run([self.gmr, *arguments], cwd=self.folder, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"gmr {' '.join(arguments)}: {done.stderr}")
        return done.stdout

    def board(self, *arguments):
        if os.path.islink(self.link):
            os.remove(self.link)
        line = [self.gmr, "board", "--link", self.link, "--flash", "flash.bin", "--image", self.image, *arguments]
        process = subprocess.Popen(line, cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while not os.path.exists(self.link):
            if process.poll() is not None:
                raise SystemExit(f"gmr board: {process.stderr.read()}")
            time.sleep(0.02)
        return process

    def teach(self):
        """Coefficients into the board's flash."""
        for name, mass, seed in (("empty", 1, 1), ("full", 6, 2)):
            board = self.board("--wait", "--speed", "4", "--profile", "training", "--mass", str(mass), "--seed", str(seed), "--duration", "115")
            self.run("record", "--port", self.link, "--mass", str(mass), "--duration", "100", "--out", f"{name}.csv")
            board.communicate()
        static = json.loads(self.run("inspect", "--json", "empty.csv"))["static_states"][0]["mean_w"]
        here = os.path.dirname(os.path.abspath(__file__))
        with open(os.path.join(here, "../../host-tools/robots/burger.toml")) as file:
            robot = file.read().replace("\n[", f"\nstatic_power_w = {static:.4f}\n\n[", 1)
        with open(os.path.join(self.folder, "robot.toml"), "w") as file:
            file.write(robot)
        self.run("fit", "--robot", "robot.toml", "--out", "coefficients.toml", "empty.csv", "full.csv")
        board = self.board("--wait", "--speed", "8", "--profile", "standstill", "--duration", "20")
        self.run("flash", "--robot", "robot.toml", "--coeffs", "coefficients.toml", "--port", self.link)
        board.communicate()


class Client:
    """Reads the board's registers."""

    def __init__(self, link):
        self.port = os.open(link, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.port)
        self.bytes = bytearray()

    def read(self, address, length):
        os.write(self.port, packet(2, struct.pack("<HH", address, length)))
        until = time.monotonic() + 5
        while time.monotonic() < until:
            try:
                self.bytes += os.read(self.port, 4096)
            except OSError:
                return None
            for body in answers(self.bytes):
                if len(body) == 2 + length and body[1] == 0:
                    return body[2:]
        return None

    def look(self):
        data = self.read(*BLOCK)
        if data is None:
            return None
        at = lambda form, address: struct.unpack_from("<" + form, data, address - BLOCK[0])
        return {
            "uptime_s": at("Q", 548)[0] / 1e6,
            "energy_j": at("4f", 604),
            "rails": at("4B", 620),
            "readings": at("20I", 624)[0::5],
            "wheels": at("2B", 720),
            "payload_state": at("B", 748)[0],
            "mass_kg": at("f", 752)[0],
            "low_kg": at("f", 756)[0],
            "high_kg": at("f", 760)[0],
            "measured_j": at("f", 772)[0],
            "predicted_j": at("f", 776)[0],
            "samples": at("I", 792)[0],
            "missed": at("I", 796)[0],
        }

    def counted(self):
        """Samples that the measured and the predicted energy count."""
        data = self.read(*COUNTED_BLOCK)
        return struct.unpack("<2I", data) if data else None


class Truth:
    """The plant's rows, read as they come."""

    def __init__(self, path):
        self.file, self.rest, self.energy, self.actuation, self.last = open(path), "", [0.0] * 4, 0.0, None
        self.columns, self.mass, self.changed, self.changes = None, None, 0.0, 0

    def until(self, seconds):
        """What was true then: energies up to that time."""
        while True:
            line = self.file.readline()
            if not line.endswith("\n"):
                # Not whole yet: the rest comes later.
                self.file.seek(self.file.tell() - len(line.encode()))
                return False
            if self.columns is None:
                self.columns = {name: i for i, name in enumerate(line.strip().split(","))}
                continue
            row = [float(value) if value else math.nan for value in line.split(",")]
            now = row[0]
            if self.last is not None:
                step = now - self.last
                self.actuation += max(0.0, row[self.columns["power_w"]]) * step
                for i, name in enumerate(RAILS):
                    # What passes the shunt, either way.
                    self.energy[i] += row[self.columns[f"{name}_w"]] * step
            mass = row[self.columns["mass_kg"]]
            if mass != self.mass:
                self.mass, self.changed, self.changes = mass, now, self.changes + 1
            self.last = now
            if now >= seconds:
                return True


def soak(tools, arguments):
    seconds = arguments.hours * 3600
    generator = random.Random(arguments.seed)
    (times, script), steps = faults(generator, seconds), payloads(generator, seconds)
    with open(os.path.join(tools.folder, "faults.toml"), "w") as file:
        file.write("\n\n".join(script) + "\n")
    truth_path = os.path.join(tools.folder, "truth.csv")
    board = tools.board("--wait", "--speed", "max", "--profile", "test", "--mass", steps, "--seed", str(arguments.seed + 2),
                        "--duration", str(seconds), "--faults", "faults.toml", "--truth", truth_path)
    client, seen, begun, next_look = Client(tools.link), [], time.monotonic(), 0.0
    while board.poll() is None:
        found = client.look()
        if found is None:
            break
        # Every look keeps the board going; five a second are kept.
        if found["uptime_s"] >= next_look:
            counted = client.counted()
            if counted is None:
                break
            seen.append(found | {"counted": counted})
            next_look = found["uptime_s"] + 0.2
        if arguments.wall_minutes and time.monotonic() - begun > 60 * arguments.wall_minutes:
            break
        time.sleep(0.005)
    board.send_signal(2)
    board.communicate()
    return judge(Truth(truth_path), seen, times, time.monotonic() - begun)


def judge(truth, seen, times, wall_s):
    errors, previous, counted, covered, drawn, held = [], None, (0, 0), [0.0, 0.0], 0.0, 0
    worst = {name: 0.0 for name in RAILS}
    for found in seen:
        if not truth.until(found["uptime_s"]):
            break
        if found["payload_state"] == 0 and found["uptime_s"] - truth.changed > WINDOW_S + 5:
            errors.append(abs(found["mass_kg"] / truth.mass - 1))
            held += found["low_kg"] <= truth.mass <= found["high_kg"]
        # Of what the plant drew since the look before, the share of the time that each energy counts.
        step = found["uptime_s"] - (previous["uptime_s"] if previous else 0.0)
        for i in range(2):
            covered[i] += (truth.actuation - drawn) * min(1.0, (found["counted"][i] - counted[i]) / (RATE * step))
        counted, drawn = found["counted"], truth.actuation
        previous = found
        energy_errors = [found["energy_j"][i] / max(1e-9, truth.energy[i]) - 1 for i in range(4)]
        if found["uptime_s"] > SETTLED_S:
            worst = {name: max(worst[name], abs(energy_errors[i])) for i, name in enumerate(RAILS)}
    errors.sort()
    hours = previous["uptime_s"] / 3600
    at = lambda share: errors[min(len(errors) - 1, int(len(errors) * share))] if errors else None
    found = {
        "hours": round(hours, 3),
        "wall_minutes": round(wall_s / 60, 1),
        "faults": sum(at < previous["uptime_s"] for at in times),
        "payloads": truth.changes,
        "samples_s": round(previous["samples"] / previous["uptime_s"], 3),
        "missed_deadlines": previous["missed"],
        "energy_error": {name: round(previous["energy_j"][i] / truth.energy[i] - 1, 5) for i, name in enumerate(RAILS)},
        "worst_energy_error": {name: round(value, 5) for name, value in worst.items()},
        "measured_actuation_error": round(previous["measured_j"] / covered[0] - 1, 5),
        "predicted_actuation_error": round(previous["predicted_j"] / covered[1] - 1, 5),
        "actuation_covered": [round(part / truth.actuation, 4) for part in covered],
        "mass_error": {"looks": len(errors), "median": at(0.5), "p95": at(0.95), "worst": at(1.0)},
        "mass_covered": round(held / len(errors), 4) if errors else None,
        "rails": previous["rails"],
        "wheels": previous["wheels"],
    }
    # A run that ends before says nothing of energies.
    settled = previous["uptime_s"] > SETTLED_S
    energies = found["energy_error"].items() if settled else ()
    wrong = [f"{name}: {error:+.2%} of its energy" for name, error in energies if abs(error) > MOST_ENERGY_ERROR]
    # Five looks a second.
    if len(errors) >= 5 * COVERED_FROM_S and not COVERED[0] <= found["mass_covered"] <= COVERED[1]:
        wrong.append(f"mass: its 95 % interval holds the truth {found['mass_covered']:.1%} of the time")
    if not errors or at(0.5) > MOST_ERROR:
        wrong.append(f"mass: median error {at(0.5)}")
    for name in ("measured", "predicted"):
        if abs(found[f"{name}_actuation_error"]) > MOST_ENERGY_ERROR:
            wrong.append(f"{name} actuation energy: {found[f'{name}_actuation_error']:+.2%}")
    if abs(found["samples_s"] - 200) > 0.5:
        wrong.append(f"{found['samples_s']} samples a second")
    found["wrong"] = wrong
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("gmr")
    parser.add_argument("image")
    parser.add_argument("--hours", type=float, default=4.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", default="soak-output")
    parser.add_argument("--wall-minutes", type=float)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    os.makedirs(arguments.folder, exist_ok=True)
    tools = Tools(arguments.gmr, arguments.image, os.path.abspath(arguments.folder))
    for name in ("flash.bin", "empty.csv", "full.csv", "coefficients.toml", "truth.csv"):
        if os.path.exists(os.path.join(tools.folder, name)):
            os.remove(os.path.join(tools.folder, name))
    tools.teach()
    found = soak(tools, arguments)
    print(json.dumps(found) if arguments.json else "\n".join(f"{k}: {v}" for k, v in found.items()))
    sys.exit(1 if found["wrong"] else 0)


if __name__ == "__main__":
    main()

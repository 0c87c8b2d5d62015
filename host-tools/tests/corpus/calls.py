"""The calls of the corpus: right and wrong inputs to every command that needs no board, in an order in which later ones may read what
earlier ones wrote."""

import math
import shutil
from pathlib import Path

DATA = Path(__file__).resolve().parents[2] / "formats/tests/data"
BAGS = ["drive.mcap", "second.mcap", "drive.db3", "drive.ulg", "drive.parquet", "clearpath.mcap", "husarion.db3", "odometry.mcap", "turtlebot3.mcap"]

ROBOT = """\
name = "exact"
kinematics = "differential"
wheel_radius_m = 0.033
track_m = 0.16
gyration_radius_m = 0.06
mass_no_load_kg = 1
mass_full_load_kg = 6
filter_cutoff_hz = 20
"""
BURGER = ROBOT.replace('"exact"', '"TurtleBot3 Burger"').replace("0.06\n", "0.064\n").replace("_hz = 20", "_hz = 1.0")
BATTERY = "[battery]\ncapacity_ah = 1.8\ncells = 3\ncutoff_v = 9\n"
PX4 = '\n[topics]\npower = "drive_power:power_w"\nmass = "payload:mass_kg"\n'
HEADER = "time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg\n"


def row(time: float, mass: float, static_w: float = 0.0) -> tuple[float, float, float, float, float]:
    """A drive of three tones a wheel, and the power that the signed torque model gives it."""
    tones = [
        [(3.0, 0.9, 0.0), (1.5, 2.3, 0.4), (0.8, 4.3, 1.0)],
        [(2.6, 0.7, 0.5), (1.7, 1.9, 1.1), (0.7, 3.7, 0.2)],
    ]
    speed = [sum(size * math.sin(rate * time + phase) for size, rate, phase in wheel) for wheel in tones]
    acceleration = [sum(size * rate * math.cos(rate * time + phase) for size, rate, phase in wheel) for wheel in tones]
    a0, a1, g2, g3, g4, kappa = 0.05, 0.008, 0.007, 0.0065, 1.6, 2.5
    radius, track, gyration = 0.033, 0.16, 0.06
    left, right = acceleration
    forward = radius / 2 * (radius * (left + right) / 2)
    turning = gyration * gyration * radius / track * (radius * (right - left) / track)
    power = static_w
    for w, a, inertial in zip(speed, acceleration, (forward - turning, forward + turning)):
        h = math.copysign(1.0, w) if abs(w) > 0.02 else 0.0
        torque = (a0 + a1 * mass) * h + g2 * w + g3 * a + g4 * mass * inertial
        power += max(0.0, torque * w + kappa * torque * torque)
    return time, speed[0], speed[1], power, mass


def log(seconds: float, rate: float, mass, static_w: float = 0.0, header: str = HEADER, end: str = "") -> str:
    lines = [header]
    for k in range(int(seconds * rate)):
        time, one, two, power, kg = row(k / rate, mass(k / rate), static_w)
        lines.append(f"{time:.4f},{one:.9f},{two:.9f},{power:.9f},{kg:g}{end}\n")
    return "".join(lines)


def inputs(folder: Path) -> None:
    def put(name: str, content: str | bytes) -> None:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)

    put("r.toml", ROBOT + BATTERY)
    put("total.toml", ROBOT + "static_power_w = 2.0\n" + BATTERY)
    put("burger.toml", BURGER)
    put("px4.toml", BURGER + PX4)
    put("unknown.toml", ROBOT + "colour = \"red\"\n")
    put("no-track.toml", ROBOT.replace("track_m = 0.16\n", ""))
    put("not.toml", "this is no robot\n")
    put("other.toml", ROBOT.replace("0.033", "0.05"))
    good = log(40, 50, lambda time: 1.0 if time < 20 else 6.0)
    put("good.csv", good)
    put("empty.csv", log(40, 50, lambda _: 1.0))
    put("full.csv", log(40, 50, lambda _: 6.0))
    put("three.csv", log(60, 50, lambda _: 3.0))
    put("load.csv", log(100, 50, lambda time: 2.0 if time < 50 else 5.0))
    total = [log(60, 50, lambda _, kg=kg: kg, 2.0, HEADER.replace("\n", ",bus_v\n"), ",12") for kg in (1.0, 6.0, 3.0)]
    for name, text in zip(("total-1.csv", "total-6.csv", "total-3.csv"), total):
        put(name, text)
    put("no-mass.csv", "".join(",".join(line.split(",")[:4]) + "\n" for line in good.splitlines()))
    put("short.csv", "".join(good.splitlines(True)[:12]))
    put("one-row.csv", "".join(good.splitlines(True)[:2]))
    put("empty-file.csv", "")
    put("header.csv", HEADER)
    put("text.csv", good.replace("0.4000,", "0.4000,abc", 1))
    put("backwards.csv", good.replace("\n0.4000,", "\n0.1000,", 1))
    put("holes.csv", good.replace("\n0.4000,", "\n0.4000,,", 1).replace(",,", ",", 1).replace("\n0.5000,", "\nnan,", 1))
    put("comma.csv", good.replace(",", ";"))
    put("fields.csv", good.replace("\n0.4000,", "\n0.4000,1,", 1))
    put("twice.csv", good.replace("wheel2_rad_s", "wheel1_rad_s", 1))
    put("cr.csv", good.replace("\n", "\r"))
    put("utf16.csv", good.encode("utf-16"))
    put("negative.csv", good.replace(",1\n", ",-1\n"))
    put("standing.csv", HEADER + "".join(f"{k / 50:.2f},0,0,0.5,1\n" for k in range(1500)))
    put("milliwatt.csv", HEADER + "".join(f"{t:.2f},{a:.6f},{b:.6f},{1000 * p:.6f},{m:g}\n" for t, a, b, p, m in (row(k / 50, 1.0 + 5 * (k > 1000)) for k in range(2000))))
    put("runs.csv", HEADER.replace("\n", ",run\n") + "".join(f"{t:.2f},{a:.6f},{b:.6f},{p:.6f},{m:g},{'one' if k < 1000 else 'two'}\n" for k in range(2000) for t, a, b, p, m in [row((k % 1000) / 50, 1.0 if k < 1000 else 6.0)]))
    put("plan.csv", "time_s,v_m_s,omega_rad_s\n0,0.12,0\n20,0.12,0\n25,0.1,0.5\n30,0,0\n")
    put("hill.csv", "time_s,v_m_s,omega_rad_s,slope_rad\n0,0.12,0,0.05\n20,0.12,0,0.05\n")
    put("legs.csv", "leg,distance_m,speed_m_s,turn_rad,pause_s\nthere,1,0.1,0,3\nback,1,0.1,3.14159265,0\n")
    put("bad-plan.csv", "time_s,v_m_s\n0,0.1\nx,0.1\n")
    put("effects.toml", '[[effect]]\nid = "my-fan"\nunit = "W"\nregressor = "1"\n')
    put("thesis.txt", "years of work\n")
    put("out/thesis.tex", "years of work\n")
    for name in BAGS:
        shutil.copy(DATA / name, folder / name)
    bag = (folder / "drive.mcap").read_bytes()
    put("cut.mcap", bag[: len(bag) * 2 // 3])
    put("noise.mcap", bag[:8] + bytes(range(256)) * 8)


CALLS: list[tuple[str, list[str]]] = []


def add(name: str, *calls: str) -> None:
    CALLS.extend((name, call.split()) for call in calls)


def both(name: str, *calls: str) -> None:
    """As text, and as JSON."""
    for call in calls:
        add(name, call, f"{call} --json")


COMMANDS = (
    "look inspect convert simulate fit gram fleet estimate predict export compare gap gap-bench reproduce board record flash key watch "
    "node new-robot completions man"
).split()

# What every command says of itself, and of nothing.
add("help", "--help", "--version", "", "nothing", *(f"{command} --help" for command in COMMANDS))
add("usage", *(command for command in COMMANDS[:-3] if command not in ("board", "gap-bench", "simulate")))
add("shell", "completions bash", "completions zsh", "completions ksh", "man", "man --out pages")

# The simulated robot: what it writes is read by what follows.
GEARED = "--plant gearmotor --sensors servo --rate 20 --power-noise 0.05 --duration 60"
both(
    "simulate",
    "simulate --duration 20 --rate 20 --mass 1@0,6@10 --seed 7 --out s.csv",
    "simulate --duration 10 --rate 20 --kinematics mecanum --out mecanum.csv",
    "simulate --duration 10 --rate 20 --effect grade=0.05 --columns command --truth --no-mass --out hill-log.csv",
    "simulate --duration 10 --rate 20 --plant table3 --profile test --seed 3 --static-power 2 --out table3.csv",
    "simulate --effects",
)
add(
    "simulate",
    "simulate --duration 10 --rate 20",
    "simulate --profile plan.csv --duration 20 --rate 20 --out planned.csv",
    "simulate --profile trainig",
    "simulate --duration -1",
    "simulate --mass 1@5 --out x.csv",
    "simulate --effect nothing=1 --out x.csv",
    "simulate --effect grade --out x.csv",
    "simulate --duration 5 --out thesis.txt",
    "simulate --duration 5 --out nowhere/x.csv",
)
for place, mass in enumerate([1, 2, 3, 4, 5, 6]):
    add("simulate-base", f"simulate {GEARED} --profile {'test' if place % 2 else 'training'} --mass {mass} --seed {100 + place} --out b{place}.csv")
for place, mass in enumerate([1.2, 5.6, 2.4, 4.1, 3.3, 1.8, 5.0, 2.9]):
    profile = "test" if place % 2 else "training"
    add("simulate-field", f"simulate {GEARED} --profile {profile} --mass {mass} --seed {200 + place} --effect grade=0.06 --out f{place}.csv")
for robot in "ab":
    for day in (2, 3):
        seed = 10 * ord(robot) + day
        add("simulate-fleet", f"simulate --duration 40 --rate 20 --seed {seed} --mass {1 + seed % 5} --columns command --out logs/robot={robot}/day=2026-11-0{day}/0.csv")

# What is in a log.
LOGS = ["good.csv", "no-mass.csv", "holes.csv", "standing.csv", "milliwatt.csv", "runs.csv", "total-3.csv", *BAGS]
WRONG = [
    "absent.csv", "empty-file.csv", "header.csv", "one-row.csv", "short.csv", "text.csv", "backwards.csv", "comma.csv", "fields.csv",
    "twice.csv", "cr.csv", "utf16.csv", "negative.csv", "cut.mcap", "noise.mcap", "logs", "thesis.txt", "mecanum.csv",
]
both("look", *(f"look {log}" for log in ["good.csv", "drive.mcap", "turtlebot3.mcap", "clearpath.mcap", "drive.ulg", "odometry.mcap"]), "look good.csv drive.mcap")
add("look", "look good.csv --page look.html", "look drive.mcap --page bag.html", *(f"look {log}" for log in WRONG), "look cut.mcap --allow-truncated")
add("inspect", *(f"inspect --robot burger.toml {log} --json" for log in LOGS))
add("inspect", *(f"inspect --robot r.toml {log}" for log in WRONG))
both("inspect", "inspect --robot r.toml good.csv --plot i.svg --force", "inspect --robot total.toml total-3.csv", "inspect --robot px4.toml drive.ulg")
add(
    "inspect",
    "inspect good.csv",
    "inspect --robot unknown.toml good.csv",
    "inspect --robot no-track.toml good.csv",
    "inspect --robot not.toml good.csv",
    "inspect --robot lost.toml good.csv",
    "inspect --robot burgr good.csv",
    "inspect --robot burger.toml cut.mcap --allow-truncated",
    "inspect --robot r.toml milliwatt.csv --power-unit mW",
    "inspect --robot r.toml good.csv --speed-unit rpm --flip-wheel 2",
    "inspect --robot r.toml good.csv --flip-wheel 3",
    "inspect --robot r.toml good.csv --plot thesis.txt",
    "inspect --robot r.toml good.csv --plot good.csv",
)
both("convert", *(f"convert --robot burger.toml {log} --out {place}.csv --force" for place, log in enumerate(["drive.mcap", "drive.db3", "turtlebot3.mcap", "odometry.mcap"])))
add(
    "convert",
    "convert --robot r.toml good.csv --out good.parquet",
    "convert --robot r.toml good.csv --out good.mcap",
    "convert --robot r.toml empty.csv full.csv --out both.csv",
    "convert --robot r.toml no-mass.csv --mass 3 --out massed.csv",
    "convert --robot r.toml good.csv --mass 3 --out x.csv",
    "convert --robot r.toml good.csv --mass -1 --out x.csv",
    "convert --robot r.toml good.csv --out x.txt",
    "convert --robot r.toml good.csv --out good.csv",
    "convert --robot burger.toml cut.mcap --out x.csv",
    "convert --robot burger.toml cut.mcap --allow-truncated --out half.csv",
    "inspect --robot r.toml good.parquet --json",
    "inspect --robot r.toml good.mcap --json",
)

# Fits.
both(
    "fit",
    "fit --robot r.toml empty.csv full.csv --out c.toml",
    "fit --robot r.toml good.csv --model eq18 --out eq18.toml",
    "fit --robot r.toml good.csv --model eq18-published --iterations 2000 --out published.toml",
    "fit --robot total.toml total-1.csv total-6.csv --out total-c.toml",
    "fit --robot r.toml runs.csv --starts 2",
    "fit --robot burger.toml drive.mcap second.mcap --out bag.toml",
    "fit --out geared.toml b0.csv b1.csv b2.csv b3.csv b4.csv b5.csv",
)
add("fit", *(f"fit --robot r.toml {log}" for log in [*WRONG, "no-mass.csv", "holes.csv", "standing.csv", "milliwatt.csv", "three.csv"]))
add(
    "fit",
    "fit --robot r.toml no-mass.csv empty.csv --mass 6",
    "fit --robot r.toml good.csv --mass 0",
    "fit --robot r.toml good.csv --mass nan",
    "fit --robot r.toml good.csv --model newton",
    "fit --robot r.toml good.csv --method nnls",
    "fit --robot r.toml good.csv --model eq18 --method physical",
    "fit --robot r.toml good.csv --model eq18 --learning-rate 0",
    "fit --robot r.toml good.csv --model eq18 --starts 2",
    "fit --robot r.toml good.csv --out good.csv",
    "fit --robot r.toml good.csv --out thesis.txt",
    "fit --robot r.toml good.csv --out nowhere/c.toml",
    "fit --robot r.toml good.csv --no-gyro --json",
    "fit --robot px4.toml drive.ulg --json",
    "fit --robot burger.toml drive.parquet --json",
)
both("gram", "gram --robot r.toml empty.csv full.csv three.csv --out g.jsonl", "gram --robot r.toml --coeffs c.toml empty.csv full.csv --out near.jsonl")
add(
    "gram",
    "gram --robot r.toml empty.csv full.csv --out g.parquet",
    "gram --robot r.toml empty.csv --cutoff 5 --out cut.jsonl",
    "gram --robot r.toml no-mass.csv --mass 2 --out massed.jsonl",
    "gram --robot r.toml no-mass.csv --out nomass.jsonl",
    "gram --robot r.toml text.csv --out x.jsonl",
    "gram --robot r.toml good.csv --out thesis.txt",
    "gram --robot r.toml good.csv --mass 0 --out x.jsonl",
)
both(
    "fit-grams",
    "fit --robot r.toml --grams g.jsonl --model eq18",
    "fit --robot r.toml --grams g.jsonl --model eq18 --leave-one-out",
    "fit --robot r.toml --grams near.jsonl --coeffs c.toml --out step.toml",
)
add("fit-grams", "fit --robot r.toml --grams g.parquet --model eq18", "fit --robot r.toml --grams g.jsonl --out x.toml", "fit --robot r.toml --grams good.csv")

# What a fit is for.
both(
    "estimate",
    "estimate --robot r.toml --coeffs c.toml load.csv",
    "estimate --robot r.toml --coeffs c.toml three.csv --mass 3 --power p.csv --plot e.svg",
    "estimate --robot r.toml --coeffs eq18.toml three.csv --payload roots",
    "estimate --robot r.toml --coeffs c.toml load.csv --schedule known --changes 50 --no-detection",
    "estimate --robot total.toml --coeffs total-c.toml total-3.csv",
    "estimate --robot burger.toml --coeffs bag.toml drive.mcap",
    "estimate --coeffs geared.toml f0.csv",
)
add("estimate", *(f"estimate --robot r.toml --coeffs c.toml {log}" for log in [*WRONG, "no-mass.csv", "standing.csv"]))
add(
    "estimate",
    "estimate --robot r.toml three.csv",
    "estimate --robot r.toml --coeffs lost.toml three.csv",
    "estimate --robot r.toml --coeffs r.toml three.csv",
    "estimate --robot other.toml --coeffs c.toml three.csv",
    "estimate --robot r.toml --coeffs c.toml three.csv --window 0",
    "estimate --robot r.toml --coeffs c.toml three.csv --mass -2",
    "estimate --robot r.toml --coeffs c.toml three.csv --schedule never",
    "estimate --robot r.toml --coeffs c.toml three.csv --schedule periodic --every 5",
    "estimate --robot r.toml --coeffs c.toml three.csv --plot three.csv",
    "estimate --robot r.toml --coeffs c.toml three.csv --plot a.pdf",
)
both(
    "predict",
    "predict --robot r.toml --coeffs c.toml --plan plan.csv --mass 3",
    "predict --robot r.toml --coeffs c.toml --plan hill.csv --mass 3 --mass-interval 2.5,3.5 --static-power 5",
    "predict --robot r.toml --coeffs c.toml --plan legs.csv --mass 2 --static-power 5 --charge 0.6",
    "predict --robot r.toml --coeffs c.toml --plan three.csv --mass 3",
)
add(
    "predict",
    "predict --robot r.toml --coeffs c.toml --plan bad-plan.csv --mass 3",
    "predict --robot r.toml --coeffs c.toml --plan lost.csv --mass 3",
    "predict --robot r.toml --coeffs c.toml --plan plan.csv --mass 0",
    "predict --robot r.toml --coeffs c.toml --plan plan.csv --mass 3 --mass-interval 4,5",
    "predict --robot r.toml --coeffs c.toml --plan plan.csv --mass 3 --charge 2",
)
both(
    "export",
    "export rmf --robot r.toml --coeffs c.toml --mass 3 --static-power 5",
    "export vda5050 --robot r.toml --coeffs c.toml --mass 3 --static-power 5 --charge 0.7",
    "export sdf --robot r.toml --coeffs c.toml --mass 3",
    "export mjcf --robot r.toml --coeffs c.toml",
)
add("export", "export mjcf --robot r.toml --coeffs c.toml --out wheel.xml", "export mjcf --robot r.toml --coeffs eq18.toml", "export rmf --robot r.toml --coeffs c.toml", "export urdf --coeffs c.toml")
both(
    "compare",
    "compare --list",
    "compare --robot r.toml --train empty.csv full.csv --test three.csv --no-perceptron --plot cmp.svg",
    "compare --robot r.toml --train good.csv --block 4 --no-perceptron",
)
add(
    "compare",
    "compare --robot r.toml",
    "compare --robot r.toml --train good.csv --models nothing",
    "compare --robot r.toml --train good.csv --window 0",
    "compare --robot r.toml --train good.csv --block 0",
    "compare --robot r.toml --train good.csv --mass 0",
    "compare --robot r.toml --train no-mass.csv --test three.csv --mass 2 --no-perceptron --json",
    "compare --robot r.toml --train text.csv --no-perceptron",
    "compare --robot r.toml --train good.csv --plot out.pdf",
)

# Where model and measurement disagree.
FIELD = " ".join(f"f{place}.csv" for place in range(8))
CLEAN = " ".join(f"b{place}.csv" for place in range(6))
both(
    "gap",
    f"gap --coeffs geared.toml --report gap.html --out extended.toml --profile drive.csv.profile {FIELD}",
    f"gap --coeffs geared.toml {CLEAN}",
    f"gap {FIELD} --base {CLEAN}",
)
add(
    "gap",
    f"gap --coeffs geared.toml --plant gearmotor {FIELD} --json",
    f"gap --coeffs geared.toml --effects effects.toml {FIELD} --json",
    f"gap --coeffs geared.toml --effects not.toml {FIELD}",
    "gap --coeffs geared.toml f0.csv f1.csv f2.csv",
    f"gap --coeffs eq18.toml {FIELD}",
    f"gap --coeffs geared.toml f0.csv {FIELD}",
    f"gap --coeffs geared.toml --mass 0 {FIELD}",
    f"gap --coeffs geared.toml --report x.html --out x.html {FIELD}",
    f"gap --coeffs geared.toml --part 2 {FIELD}",
    f"gap --coeffs geared.toml --room 3 {FIELD}",
    f"gap --coeffs geared.toml --export mjcf {FIELD}",
    "gap --robot r.toml --coeffs c.toml text.csv empty.csv full.csv three.csv",
    "estimate --coeffs extended.toml f1.csv --json",
)
add("gap-bench", "gap-bench --seeds 1 --sizes 2 --free 1 --only grade", "gap-bench --seeds 1 --sizes 2 --free 0 --only grade --removed 0 --json")

# Fleets, the paper, boards without a board, nodes without ROS.
both("fleet", "fleet logs --coeffs geared.toml --out fleet")
add("fleet", "fleet nowhere --coeffs geared.toml --out fleet2", "fleet logs --coeffs lost.toml --out fleet2", "fleet logs --coeffs geared.toml --mass 0 --out fleet2", "fleet logs --coeffs geared.toml --out thesis.txt")
add("reproduce", "reproduce --out out", "reproduce --out nowhere/out", "reproduce --seeds 0 --out paper")
add(
    "flash",
    "flash --robot r.toml --coeffs c.toml --out store.bin",
    "flash --robot r.toml --coeffs c.toml --out store.hex --json",
    "flash --robot r.toml --coeffs eq18.toml --adapt --out x.bin",
    "flash --robot r.toml --coeffs c.toml --out thesis.txt",
    "flash --robot r.toml --coeffs c.toml --port /dev/not-there",
    "flash --robot r.toml --out x.bin",
    "record --port /dev/not-there --out x.csv",
    "watch --port /dev/not-there --once",
    "key show thesis.txt",
    "key show not-there",
)
NODE = "node --robot total.toml --no-ros --speed max"
add(
    "node",
    f"{NODE} --coeffs total-c.toml --replay total-3.csv --json",
    f"{NODE} --coeffs total-c.toml --replay total-3.csv",
    f"{NODE} --replay total-3.csv --json",
    f"{NODE} --coeffs lost.toml --replay total-3.csv",
    f"{NODE} --coeffs total-c.toml --replay absent.csv",
)
add(
    "new-robot",
    "new-robot --name Rosbot --kinematics skid-steer --wheel-radius 0.0425 --track 0.22 --empty 2.9 --full 12.9 --static-power 7 --out mine.toml",
    "new-robot --name Rosbot --kinematics skid-steer --wheel-radius 0.0425 --track 0.22 --empty 2.9 --full 12.9 --out mine.toml",
    "new-robot --name Rosbot --kinematics legs",
)

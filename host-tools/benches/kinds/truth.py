"""True drives: every 5 ms the wheels' angles and the mean power, of a MuJoCo robot or of the second simulator."""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import generate
import kinds
import simulate
from plants import PLANTS, Ground, Load, xml

HERE = Path(__file__).resolve().parent
JUDGE = HERE.parent.parent / "tests" / "reference" / "gap_judge"


@dataclass(frozen=True)
class Robot:
    """A robot that is not ours, and what its logs and drives need."""
    name: str
    plant: str               # in MuJoCo; empty: the second simulator's `servo`
    speed: float             # greatest, of a wheel, rad/s
    acceleration: float      # rad/s²
    empty: float
    full: float
    radius: float
    track: float             # as its robot.toml says
    gyration: float
    regenerative: bool
    dead_band: float
    ticks: int               # encoder, a turn
    power_noise: float       # standard deviation of white noise of a sample of 5 ms, W
    power_step: float        # W
    register: float          # step of the drive's speed register, rad/s


def mujoco(name, track, dead_band, regenerative):
    p = PLANTS[name]
    volts = p.drive.supply
    return Robot(name, name, p.speed, p.acceleration, p.empty, p.full, p.radius, track, round(0.4 * p.track, 3), regenerative, dead_band,
                 p.ticks, p.current_noise * volts, p.current_step * volts, 0.229 * 2.0 * np.pi / 60.0)


# The second simulator's servo: its limits are those of tests/reference/gap_judge/robots.py. Register: XL430's unit, 0.229 rpm.
ROBOTS = (
    Robot("second simulator", "", 0.22 / 0.033, 0.8 / 0.033, 1.0, 6.0, 0.033, 0.160, 0.064, False, 0.02, 4096, 0.06, 0.0012,
          0.229 * 2.0 * np.pi / 60.0),
    mujoco("two-wheeled", 0.160, 0.02, False),
    mujoco("skid-steered", 1.04, 0.05, True),
)


@dataclass
class Drive:
    """A true drive: wheels' angles in rad (n, 2) and mean power in W (n), every 5 ms."""
    angle: np.ndarray
    power: np.ndarray


def drive(robot, mass, reference, path):
    """Drives it, or takes what was driven before with the same figures."""
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        if robot.plant:
            plant = PLANTS[robot.plant]
            load = Load(mass - plant.empty, box=0.3 * plant.length)
            record = simulate.run(plant, xml(plant, load, Ground()), reference)
            np.savez(path, angle=record.angle, power=record.power[:, 0 if robot.regenerative else 1])
        else:
            # A process of its own: its modules have the names of ours.
            asked = path.with_suffix(".npy")
            np.save(asked, reference)
            subprocess.run([sys.executable, HERE / "second.py", JUDGE, str(mass), asked, path], check=True)
    found = np.load(path)
    return Drive(found["angle"], found["power"])


def robot_file(robot, folder):
    """Its robot.toml."""
    if not robot.plant:
        return "burger"
    folder.mkdir(parents=True, exist_ok=True)
    generate.robot_file(folder, robot.name, PLANTS[robot.plant])
    return folder / f"{robot.name}.toml"


def plan(robot, drive, path):
    """The same motion as a plan of 20 Hz: forward speed and turn rate."""
    every = 10
    speed = robot.radius * np.diff(drive.angle, axis=0, prepend=0.0) * kinds.RATE_HZ
    speed = speed[: len(speed) // every * every].reshape(-1, every, 2).mean(axis=1)
    ahead, turn = speed.mean(axis=1), (speed[:, 1] - speed[:, 0]) / robot.track
    time = (np.arange(len(speed)) + 0.5) * every / kinds.RATE_HZ
    rows = np.column_stack([time, ahead, turn])
    np.savetxt(path, rows, delimiter=",", header="time_s,v_m_s,omega_rad_s", comments="", fmt="%.6f")
    return path

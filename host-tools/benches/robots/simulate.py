"""Drives a MuJoCo robot along a reference of wheel speeds: motors, speed controller, and what the battery gives.

A step: the controller (200 Hz, PI on the wheel's speed) sets a voltage; the winding's current follows at once (its time
constant is below a millisecond); the gear takes a share of the load's torque, by the direction in which power flows, and its
own friction; MuJoCo moves body, wheels and rotors. The bridge loses a voltage drop times |current|.
"""

from dataclasses import dataclass, field
from math import tanh

import mujoco
import numpy as np

CONTROL_S = 0.005
# Below this share of the greatest speed a drive told to stand lets go: its winding is shorted.
LET_GO = 0.02


@dataclass
class Changes:
    """What differs from the plant as built; the effects of the gap workflow use these."""
    coulomb: tuple = (1.0, 1.0)            # gear friction's factor, by side
    drag: tuple = (0.0, 0.0)               # further friction, N·m
    viscous: float = 1.0
    loss: float = 1.0                      # gear loss by load: factor of both
    resistance: object = None              # factor of the winding's resistance at a time, or None
    supply: object = None                  # factor of the supply's voltage at a time and battery current, or None
    # Further torque against the wheel's positive sense, N·m, of (side, its angle and speed, the gear's load, time).
    brake: object = None
    ground_at: list = field(default_factory=list)   # (from time, slide factor, roll factor)


@dataclass
class Record:
    """Every 5 ms: true wheel angles, mean power, body's state; and the checks of the plant."""
    time: np.ndarray
    angle: np.ndarray        # (n, 2) rad
    power: np.ndarray        # (n, 2) battery, W: braking power returned to it, and turned into heat by each bridge
    rates: np.ndarray        # yaw rate, forward speed
    pitch: np.ndarray
    checks: dict


def run(plant, xml, reference, changes=None, check=False):
    """`reference`: (n, 2) wheel speeds, rad/s, one row for each 5 ms."""
    c = changes or Changes()
    d = plant.drive
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    sub = round(CONTROL_S / plant.step_s)
    h = plant.step_s
    sides = ("left", "right")
    dof = [model.joint(name).dofadr[0] for name in sides]
    angle_at = [model.joint(name).qposadr[0] for name in sides]
    inertia = float(model.dof_armature[dof[0]]) * (1 if plant.base == 0 else 2)
    wheels = range(2 if plant.base == 0 else 4)      # contact pairs: the wheels' come first
    friction = model.pair_friction.copy()
    data.qpos[2] = 0.0
    for _ in range(round(1.0 / h)):      # settles on its contacts before the clock starts
        mujoco.mj_step(model, data)
    start = [float(data.qpos[a]) for a in angle_at]
    n = len(reference)
    angle, power = np.zeros((n, 2)), np.zeros((n, 2))
    rates, pitch = np.zeros((n, 2)), np.zeros(n)
    integral = [0.0, 0.0]
    speed = [0.0, 0.0]
    slow = [0.0, 0.0]                    # wheel's acceleration, smoothed: what the rotor takes from the gear's load
    kp, ki = plant.gain
    smooth = 0.02 * plant.speed / 5.0    # rad/s over which friction turns
    work, lost, kept, contact = 0.0, 0.0, [], []
    qvel, applied = data.qvel, data.qfrc_applied
    step = mujoco.mj_step
    begin = data.time
    forward = np.zeros(6)
    pending = sorted(c.ground_at)
    battery_current = 0.0
    for k in range(n):
        now = k * CONTROL_S
        while pending and now >= pending[0][0]:
            _, slide, roll = pending.pop(0)
            for g in wheels:
                model.pair_friction[g] = friction[g] * (slide, slide, 1.0, roll, roll)
        supply = d.supply * (c.supply(now, battery_current) if c.supply else 1.0)
        resistance = d.resistance * (c.resistance(now) if c.resistance else 1.0)
        volts = []
        for s in range(2):
            goal = float(reference[k, s])
            if goal == 0.0 and abs(speed[s]) < LET_GO * plant.speed:
                integral[s] = 0.0
                volts.append(0.0)
                continue
            error = goal - speed[s]
            v = d.constant * goal + kp * error + integral[s]
            limit = supply - d.drop
            if -limit < v < limit:
                integral[s] += ki * error * CONTROL_S
            volts.append(min(max(v, -limit), limit))
        regenerative, clamped = 0.0, 0.0
        for _ in range(sub):
            for s in range(2):
                w = float(qvel[dof[s]])
                i = (volts[s] - d.constant * w) / resistance
                torque = d.constant * i
                load = torque - inertia * slow[s]
                direction = tanh(w / smooth)
                share = d.loss_forward if load * w > 0.0 else d.loss_backward
                friction_torque = (d.coulomb * c.coulomb[s] + c.drag[s] + c.loss * share * abs(load)) * direction
                out = torque - friction_torque - d.viscous * c.viscous * w
                if c.brake:
                    out -= c.brake(s, float(data.qpos[angle_at[s]]) - start[s], w, load, now)
                applied[dof[s]] = out
                p = volts[s] * i + d.drop * abs(i)
                regenerative += p
                clamped += max(p, 0.0)
            before = (float(qvel[dof[0]]), float(qvel[dof[1]]))
            if check:
                old = qvel.copy()
            step(model, data)
            for s in range(2):
                a = (float(qvel[dof[s]]) - before[s]) / h
                slow[s] += 0.1 * (a - slow[s])
            if check:
                mean = 0.5 * (old + qvel)
                work += float(np.dot(applied, mean)) * h
                lost += float(np.dot(data.qfrc_constraint, mean)) * h
        for s in range(2):
            speed[s] = float(qvel[dof[s]])
            angle[k, s] = data.qpos[angle_at[s]] - start[s]
        power[k] = regenerative / sub, clamped / sub
        battery_current = power[k, 1] / supply
        q = data.qpos[3:7]
        pitch[k] = 2.0 * (q[0] * q[2] - q[3] * q[1])
        rates[k, 0] = qvel[5]
        rates[k, 1] = qvel[0] * (1 - 2 * (q[2] ** 2 + q[3] ** 2)) + qvel[1] * 2 * (q[1] * q[2] + q[0] * q[3])
        if check and k % 4 == 0:
            weight = 0.0
            for j in range(data.ncon):
                mujoco.mj_contactForce(model, data, j, forward)
                weight += forward[0]
            contact.append((weight, data.ncon))
            kept.append((work, lost, float(data.energy[0] + data.energy[1])))
    checks = {}
    if check:
        contact, kept = np.array(contact), np.array(kept)
        stored = kept[:, 2] - kept[0, 2]
        gone = kept[:, 1] - kept[0, 1]
        put = kept[:, 0] - kept[0, 0]
        checks = {
            "energy_balance": float(np.max(np.abs(put + gone - stored)) / max(put[-1], 1e-9)),
            "contact_force_min": float(contact[:, 0].min()), "contact_force_max": float(contact[:, 0].max()),
            "contacts_min": int(contact[:, 1].min()),
            "weight": float(model.body_mass.sum() * 9.81),
        }
    return Record(np.arange(n) * CONTROL_S, angle, power, rates, pitch, checks)

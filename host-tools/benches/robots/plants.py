"""Two robots in MuJoCo, written from data sheets and physics: they share no formula with the models that are judged on them.

Contacts, slip, rolling friction, body and rotors are MuJoCo's; winding, gear and bridge are in drive.py. A wheel touches the
ground in one point (a sphere of the wheel's radius, elliptic friction cone, rolling friction): cylinders on a plane jump
between several points. Units are SI.
"""

from dataclasses import dataclass

GRAVITY = 9.81
FIRMNESS = 200


@dataclass(frozen=True)
class Drive:
    """A DC motor with gear and bridge, seen from the wheel."""
    resistance: float        # winding, Ω
    constant: float          # gear ratio times motor constant: V·s/rad and N·m/A at the wheel
    rotor: float             # rotor's inertia times the gear ratio squared, kg·m²
    coulomb: float           # gear friction at the wheel without load, N·m
    viscous: float           # N·m·s/rad
    loss_forward: float      # share of the load's torque lost in the gear, motor drives wheel
    loss_backward: float     # the same, wheel drives motor
    drop: float              # bridge: volts lost in the direction of the current
    supply: float            # battery, V


@dataclass(frozen=True)
class Ground:
    slide: float = 0.9       # friction coefficient
    roll: float = 1.0        # times the tyre's rolling coefficient
    soft: float = 1.0        # times the time constant of a contact
    spin: float = 1.0        # times the torque against turning in place


@dataclass(frozen=True)
class Plant:
    name: str
    radius: float            # wheel, m
    track: float             # between the wheels' planes, m
    base: float              # between the axles, m; 0: two wheels and a caster
    length: float
    width: float
    height: float
    empty: float             # mass without payload, kg
    full: float
    wheel_mass: float
    caster_share: float      # of the chassis' weight that the caster carries
    roll: float              # rolling coefficient of a tyre, m
    drive: Drive
    speed: float             # greatest, of a wheel, rad/s
    acceleration: float      # greatest, of a wheel, rad/s²
    ticks: int               # encoder, a turn
    current_noise: float     # of a sample of the power sensor (mean over 5 ms), A
    current_step: float      # A
    step_s: float
    gain: tuple              # speed controller: V·s/rad, V/rad
    contact_s: float         # time constant of a contact's normal force
    slip_s: float            # and of its friction
    impedance: float         # of a contact: below 1 it yields
    usual: float             # mean power of its drives in benches, W


# XL430-W250 (stall 1.5 N·m and 1.4 A at 12 V, 6.4 rad/s without load); the paper's Table 2: 1 kg, rolling resistance 0.032.
TWO_WHEELED = Plant(
    name="two-wheeled", radius=0.033, track=0.160, base=0.0, length=0.138, width=0.10, height=0.05, empty=1.0, full=6.0,
    wheel_mass=0.05, caster_share=0.25, roll=0.032 * 0.033,
    drive=Drive(resistance=8.3, constant=1.75, rotor=0.0032, coulomb=0.065, viscous=0.006, loss_forward=0.18,
                loss_backward=0.25, drop=0.25, supply=12.0),
    speed=5.2, acceleration=12.0, ticks=4096, current_noise=0.003, current_step=0.0001, step_s=0.0025, gain=(3.0, 20.0), contact_s=0.01, slip_s=0.06, impedance=0.8,
    usual=0.65)

# Clearpath Husky A200: 24 V, one motor a side (winding 0.46 Ω, 0.0449 V·s/rad, gear 78.71), wheels of 13 inches.
SKID_STEERED = Plant(
    name="skid-steered", radius=0.165, track=0.5708, base=0.512, length=0.9, width=0.45, height=0.25, empty=50.0,
    full=125.0, wheel_mass=2.6, caster_share=0.0, roll=0.0045,
    drive=Drive(resistance=0.46, constant=78.71 * 0.0449, rotor=0.35, coulomb=2.2, viscous=0.25, loss_forward=0.12,
                loss_backward=0.16, drop=0.4, supply=26.0),
    speed=5.0, acceleration=6.0, ticks=16384, current_noise=0.06, current_step=0.01, step_s=0.0025, gain=(3.0, 15.0), contact_s=0.02, slip_s=0.15, impedance=0.3,
    usual=160.0)

PLANTS = {p.name: p for p in (TWO_WHEELED, SKID_STEERED)}


@dataclass
class Load:
    """A payload: its mass, and its centre from the middle of the chassis."""
    mass: float
    ahead: float = 0.0
    left: float = 0.0
    box: float = 0.08        # edge, m


def wheel(name, x, y, p):
    across, along = p.wheel_mass * p.radius ** 2 / 4, p.wheel_mass * p.radius ** 2 / 2
    armature = p.drive.rotor / (1 if p.base == 0 else 2)
    return f"""
      <body name="{name}" pos="{x} {y} {p.radius}">
        <joint name="{name}" type="hinge" axis="0 1 0" armature="{armature}"/>
        <inertial pos="0 0 0" mass="{p.wheel_mass}" diaginertia="{across} {along} {across}"/>
        <geom name="{name}" type="sphere" size="{p.radius}"/>
      </body>"""


def contact(name, p, ground, slide, spin, roll):
    """A contact with the ground.

    MuJoCo's contacts are convex: what slides sideways is lifted, the more the stiffer its friction is beside its normal force. With
    the defaults a robot of 490 N that spins on the spot jumps (0 to 1170 N); a time constant of 1 s for the friction cures that, but
    then it acts late. A softer constraint (a lower impedance) with 0.15 s does neither: the weight stays within 2 %, and the torque of
    a turn goes with the slip. FIRMNESS keeps a robot from creeping at rest.
    """
    return (f'<pair geom1="{name}" geom2="floor" condim="6" friction="{slide} {slide} {spin} {roll} {roll}" '
            f'solref="{ground.soft * p.contact_s} 1" solreffriction="{p.slip_s} 1" solimp="{p.impedance} {p.impedance} 0.001"/>')


def xml(p, load, ground, frictions=(1.0, 1.0, 1.0, 1.0), slope=0.0, slope_heading=0.0):
    """The model as MuJoCo's XML. A slope tilts gravity: uphill towards `slope_heading`."""
    from math import cos, sin
    down = (-GRAVITY * sin(slope) * cos(slope_heading), -GRAVITY * sin(slope) * sin(slope_heading), -GRAVITY * cos(slope))
    half = p.track / 2
    names = ("left", "right") if p.base == 0.0 else ("left", "right", "left2", "right2")
    contacts = "".join(
        contact(name, p, ground, ground.slide * f, ground.spin * 0.03 * p.radius, ground.roll * p.roll)
        for name, f in zip(names, frictions))
    if p.base == 0.0:
        wheels = wheel("left", 0.0, half, p) + wheel("right", 0.0, -half, p)
        chassis = p.empty - 2 * p.wheel_mass
        behind = 0.6 * p.length
        # A ball caster: it slides with little friction. Its load keeps the robot from rocking.
        r = 0.4 * p.radius
        caster = f'<geom name="caster" type="sphere" pos="{-behind} 0 {r}" size="{r}" mass="0"/>'
        contacts += contact("caster", p, ground, 0.06, 0.0001, 0.00001)
        at, couple = -p.caster_share * behind, ""
    else:
        front, rear = p.base / 2, -p.base / 2
        wheels = (wheel("left", front, half, p) + wheel("right", front, -half, p)
                  + wheel("left2", rear, half, p) + wheel("right2", rear, -half, p))
        chassis = p.empty - 4 * p.wheel_mass
        caster, at = "", 0.0
        # A belt turns both wheels of a side.
        couple = ('<equality><joint joint1="left2" joint2="left" solref="0.006 1"/>'
                  '<joint joint1="right2" joint2="right" solref="0.006 1"/></equality>')
    box = (chassis / 12 * (p.width ** 2 + p.height ** 2), chassis / 12 * (p.length ** 2 + p.height ** 2),
           chassis / 12 * (p.length ** 2 + p.width ** 2))
    low = p.radius + 0.1 * p.height
    inertia = load.mass * load.box ** 2 / 6
    payload = "" if load.mass <= 0.0 else (
        f'<body pos="{at + load.ahead} {load.left} {low + p.height / 2 + load.box / 2}">'
        f'<inertial pos="0 0 0" mass="{load.mass}" diaginertia="{inertia} {inertia} {inertia}"/></body>')
    return f"""
<mujoco>
  <option timestep="{p.step_s}" gravity="{down[0]} {down[1]} {down[2]}" integrator="implicitfast" cone="elliptic" impratio="{FIRMNESS}"
          iterations="50" tolerance="1e-10"><flag energy="enable"/></option>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <body name="chassis">
      <freejoint/>
      <inertial pos="{at} 0 {low}" mass="{chassis}" diaginertia="{box[0]} {box[1]} {box[2]}"/>
      {caster}{payload}{wheels}
    </body>
  </worldbody>
  {couple}<contact>{contacts}</contact>
</mujoco>"""

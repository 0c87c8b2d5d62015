"""Drives a board by the documented sequence of ROS 2's turtlebot3_node, with ROBOTIS's own client library.

    pip install dynamixel-sdk
    cargo build --release -p firmware --features virtual --bin virtual --target thumbv7em-none-eabihf
    gmr board --realtime --profile none --duration 4000 --power-noise 0 --node /tmp/node --link /tmp/link &
    python3 tests/system/node_client.py /tmp/node --minutes 3 [--json]            # an hour: --minutes 60
    gmr record --port /tmp/link --out log.csv --duration 60                        # meanwhile, on the other port

What it does: the node's start-up, then squares of 2 m for as long as asked, with the block read 20 times a second, the heartbeat 10 times
and commands 10 times; last, the heartbeat ends in the middle of a motion. What it checks stands in `main`.
"""
import argparse
import json
import math
import struct
import sys
import time

import dynamixel_sdk as sdk

BOARD = 200
BLOCK = 10, 172
# Wheel radius and track of a Burger; goal units of a wheel's 1 m/s.
RADIUS, TRACK, UNITS = 0.033, 0.160, 1263.633
LINEAR, TURN = 0.15, 0.5
SIDE = 2.0
# Of DRIVE_GOALS in the board's own table.
GOALS = 2340


class Node:
    """The SDK's port, and what its calls come back with."""

    def __init__(self, path):
        self.port = sdk.PortHandler(path)
        self.packets = sdk.PacketHandler(2.0)
        # As the C++ library does: open at its default rate, close, open at the one that is wanted.
        if not self.port.openPort() or not self.port.setBaudRate(1_000_000):
            raise SystemExit(f"{path} cannot be opened")
        self.failed, self.calls, self.late = [], 0, []

    def count(self, what, begun, result, error):
        self.calls += 1
        self.late.append(time.monotonic() - begun)
        if result != sdk.COMM_SUCCESS or error:
            self.failed.append(f"{what}: {self.packets.getTxRxResult(result)} {error}")
            return False
        return True

    def read(self, address, length):
        begun = time.monotonic()
        data, result, error = self.packets.readTxRx(self.port, BOARD, address, length)
        if not self.count(f"read {address}", begun, result, error):
            return None
        if len(data) != length:
            # The library takes a late answer for the next one's and looks at no length.
            self.failed.append(f"read {address}: {len(data)} bytes for {length}")
            return None
        return bytes(data)

    def write(self, address, data):
        begun = time.monotonic()
        result, error = self.packets.writeTxRx(self.port, BOARD, address, len(data), list(data))
        return self.count(f"write {address}", begun, result, error)


class Block:
    """What the node takes out of its block."""

    def __init__(self, data):
        at = lambda form, address: struct.unpack_from("<" + form, data, address - BLOCK[0])
        self.millis = at("I", 10)[0]
        self.status = at("b", 18)[0]
        self.positions = at("2i", 136)
        self.torque = at("B", 149)[0]
        w, x, y, z = at("4f", 96)
        self.norm = math.sqrt(w * w + x * x + y * y + z * z)
        self.yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


class Odometry:
    """The node's: the way from the wheels, the heading from the quaternion, by the midpoint rule."""

    def __init__(self, block):
        self.last, self.x, self.y, self.turned, self.way = block, 0.0, 0.0, 0.0, 0.0

    def take(self, block):
        ticks = [now - then for now, then in zip(block.positions, self.last.positions)]
        way = RADIUS * sum(ticks) / 2 * 2 * math.pi / 4096
        turn = (block.yaw - self.last.yaw + math.pi) % (2 * math.pi) - math.pi
        heading = self.turned + turn / 2
        self.x += way * math.cos(heading)
        self.y += way * math.sin(heading)
        self.turned += turn
        self.way += way
        self.last = block


def quantised(linear, angular):
    """The goals that the stock firmware makes of a command: cut to 0.01, clamped, then each wheel's."""
    top = 61 / 60 * 2 * math.pi * RADIUS
    linear = max(-top, min(top, int(linear * 100) / 100))
    angular = max(-top / 0.08, min(top / 0.08, int(angular * 100) / 100))
    return [max(-265, min(265, int((linear + side * angular * TRACK / 2) * UNITS))) for side in (-1, 1)]


class Session:
    def __init__(self, node):
        self.node, self.beat, self.wrong, self.goal_errors = node, 0, [], 0
        self.next_block = self.next_beat = time.monotonic()
        self.command_now, self.commanded, self.next_command = None, 0.0, 0.0
        self.blocks = 0
        self.periods = []

    def start(self):
        if self.node.read(0, 2) is None:
            raise SystemExit("no answer at address 0: the node would end here")
        self.node.write(59, b"\x01")
        time.sleep(1.0)
        self.odometry = Odometry(Block(self.block()))

    def block(self):
        while True:
            data = self.node.read(*BLOCK)
            if data is not None:
                return data

    def command(self, linear, angular):
        values, now = (int(linear * 100), 0, 0, 0, 0, int(angular * 100)), time.monotonic()
        if values != self.command_now:
            self.command_now, self.wanted, self.commanded = values, quantised(linear, angular), now
        elif now < self.next_command:
            return
        # As whoever publishes cmd_vel: again and again, so that a host that stalled drives on.
        self.next_command = now + 0.1
        self.node.write(150, struct.pack("<6i", *values))

    def step(self, beats=True):
        """Waits for the next of the node's timers and does what is due."""
        now = time.monotonic()
        time.sleep(max(0.0, min(self.next_block, self.next_beat) - now))
        now = time.monotonic()
        if now >= self.next_beat:
            # Overdue periods are left out, not made up for.
            self.next_beat = max(self.next_beat + 0.1, now)
            if beats:
                self.node.write(19, bytes([self.beat]))
                self.beat = (self.beat + 1) % 256
        if now >= self.next_block:
            self.periods.append(now - self.next_block)
            self.next_block = max(self.next_block + 0.05, now)
            block = Block(self.block())
            self.blocks += 1
            if abs(block.norm - 1) > 1e-3:
                self.wrong.append(f"quaternion of length {block.norm}")
            if block.status != 0 or block.torque != 1:
                self.wrong.append(f"status {block.status}, torque {block.torque}")
            self.odometry.take(block)
            # What the servos were told, a little after the command: within one unit.
            if self.command_now and self.blocks % 4 == 0 and now - self.commanded > 0.1:
                goals = struct.unpack("<2i", self.node.read(GOALS, 8) or bytes(8))
                if any(abs(goal - want) > 1 for goal, want in zip(goals, self.wanted)):
                    self.goal_errors += 1
                    self.wrong.append(f"goals {goals} for {self.wanted}")

    def straight(self, length):
        begin = self.odometry.way
        while True:
            left = length - (self.odometry.way - begin)
            if left < 0.0005:
                break
            self.command(max(0.02, min(LINEAR, left)), 0)
            self.step()
        self.rest()

    def turn(self, angle):
        begin = self.odometry.turned
        while True:
            left = angle - (self.odometry.turned - begin)
            if left < 0.003:
                break
            self.command(0, max(0.05, min(TURN, left)))
            self.step()
        self.rest()

    def rest(self):
        self.command(0, 0)
        until = time.monotonic() + 0.6
        while time.monotonic() < until:
            self.step()

    def square(self):
        """How far from its beginning it ends, m, by the odometry."""
        begin = self.odometry.x, self.odometry.y
        for _ in range(4):
            self.straight(SIDE)
            self.turn(math.pi / 2)
        return math.hypot(self.odometry.x - begin[0], self.odometry.y - begin[1])

    def lose_heartbeat(self):
        """From the last change of the heartbeat to the goals at 0, s of the host's clock: seen by reading them."""
        self.command(0.1, 0)
        until = time.monotonic() + 1.0
        while time.monotonic() < until:
            self.step()
        self.beat = (self.beat + 1) % 256
        self.node.write(19, bytes([self.beat]))
        lost = time.monotonic()
        moving = None
        while time.monotonic() - lost < 1.5:
            asked = time.monotonic()
            data = self.node.read(GOALS, 8)
            if data is None:
                continue
            if data == bytes(8):
                return moving - lost, time.monotonic() - lost
            moving = asked
        return None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("port")
    parser.add_argument("--minutes", type=float, default=3.0)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    node = Node(arguments.port)
    session = Session(node)
    session.start()
    # The first heartbeat is the value that stands there: it counts from the second one on.
    until = time.monotonic() + 0.5
    while time.monotonic() < until:
        session.step()
    end, closures = time.monotonic() + 60 * arguments.minutes, []
    while not closures or time.monotonic() < end:
        closures.append(session.square())
    stop = session.lose_heartbeat()
    late = sorted(node.late)
    wrong = session.wrong[:5]
    if node.failed:
        wrong.append(f"{len(node.failed)} calls of {node.calls} failed, the first: {node.failed[0]}")
    if max(closures) > 0.02:
        wrong.append(f"squares closed within {max(closures):.3f} m only")
    # What two readings enclose; 20 ms for the host's own delays.
    if stop is None or stop[1] < 0.500 or stop[0] > 0.525:
        wrong.append(f"goals 0 between {stop} s after the last heartbeat")
    figures = {
        "calls": node.calls,
        "failed": len(node.failed),
        "answer_ms": {"median": 1e3 * late[len(late) // 2], "p99": 1e3 * late[len(late) * 99 // 100], "worst": 1e3 * late[-1]},
        "blocks": session.blocks,
        "squares": len(closures),
        "worst_closure_m": round(max(closures), 4),
        "goal_errors": session.goal_errors,
        "stopped_between_s": stop,
        "wrong": wrong,
    }
    print(json.dumps(figures) if arguments.json else "\n".join(f"{k}: {v}" for k, v in figures.items()))
    sys.exit(1 if wrong else 0)


main()

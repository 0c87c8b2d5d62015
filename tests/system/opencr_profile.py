"""Where the instructions of a 200 Hz tick go, on the OpenCR image in the emulated STM32F746: a table by who runs and one by what it does.

    PYTHONPATH=folder/of/emu:tests/system emu tests/system/opencr_profile.py IMAGE [--seconds S] [--quiet] [--worst] [--functions N] [--json]

The robot drives by the ROS node's commands, with coefficients, four sensors, two servos and an inertial sensor; the node reads its block 20
times a second, and a recorder takes every record from the other port (--quiet: nobody is on the link). --worst tells of the tick that took
the most, and of no other. Counted are instructions, entering and
leaving an interrupt as the 22 cycles they take; no caches, no wait states. What a sleeping core does not execute is not counted.

An instruction belongs to the innermost function, of those that the compiler made one, that is in a crate named below: `PARTS`. Copies by
memcpy count as copies, whoever asked. Needs addr2line.
"""
import argparse
import collections
import json
import re
import struct
import subprocess

import unicorn
import unicorn.arm_const as arm

from board import MS, run
from opencr_emulated import Host, Node, Recorder, set_up, upload
from opencr_inertial import Sensor
from protocol import packet

DRIVE = (10, 0)
BLOCK = 10, 172
TICK = 5 * MS
THREAD = "executor, main program"
SAMPLING = 16 + 52
SETTLED_S, WARM_S = 1.5, 1.0
# First match wins, innermost function first; a path of a source file, or a name of a function.
PARTS = (
    ("copies (memcpy, memset)", r"__aeabi_mem|compiler_builtins::mem|/compiler_builtins.*/mem|^mem(cpy|set|move|cmp)$"),
    ("double precision in software", r"__aeabi_(d|l?d|[iuf]2d|ui2d|l2d|ul2d|f2d)|__(add|sub|mul|div)df3|/compiler_builtins.*/float"),
    ("long division", r"__aeabi_u?ldivmod|/compiler_builtins.*/int"),
    ("log (defmt)", r"/defmt"),
    ("critical sections", r"/critical-section|cortex_m::interrupt|/cortex-m-0.7[^/]*/src/(critical_section|interrupt)"),
    ("executor", r"/embassy-executor"),
    ("time: clock, alarms, timer queue", r"/embassy-time|firmware/src/boards/opencr/time\.rs"),
    ("I2C: driver", r"/embassy-stm32[^/]*/src/i2c|boards/opencr/sensor_bus"),
    ("servo port: driver", r"/embassy-stm32[^/]*/src/usart|boards/opencr/servo_port"),
    ("SPI: driver", r"/embassy-stm32[^/]*/src/spi|boards/opencr/inertial_port"),
    ("DMA", r"/embassy-stm32[^/]*/src/dma"),
    ("USB: driver and class", r"/embassy-usb|/embassy-stm32[^/]*/src/usb|boards/opencr/usb"),
    ("power sensors", r"/ina219|firmware/src/power_sensors|tasks/sensor_bus|/embassy-embedded-hal"),
    ("servo protocol", r"firmware/src/dynamixel"),
    ("wheels and driving", r"firmware/src/(wheels|drive)"),
    ("orientation (VQF)", r"/vqf-rs"),
    ("inertial sensor", r"firmware/src/inertial|tasks/orient"),
    ("battery's gauge", r"model-core/src/charge|measurement/battery"),
    ("estimator", r"model-core/|firmware/src/estimation"),
    ("sample, record, snapshot", r"firmware/src/(measurement|record|tasks/(measure|shared|supply|deadline)|link/fifo|link/state)"),
    ("answering the host", r"firmware/src/(link|tasks/serve|control_table|bytes|items)"),
    ("other chip support", r"/embassy-stm32|/stm32-metapac|/cortex-m|boards/opencr"),
    ("mutex, signals, join", r"/embassy-(sync|futures)|/atomic"),
    ("mathematics (libm)", r"/libm|/compiler_builtins.*/math|libm::"),
)


class Profile:
    """Executed instructions by who runs (a task, an interrupt) and where."""

    def __init__(self, machine, image):
        self.machine, self.image = machine, image
        self.counts = collections.Counter()
        # How often each interrupt came and each task was polled.
        self.entries = collections.Counter()
        self.last, self.depth = machine.st.insn, 0
        # On each level the task that runs, and where it returns to.
        self.tasks = {}
        self.polls, self.copies = task_polls(machine, image), copiers(machine)
        self.is_on = True
        self.copied = collections.Counter()
        self.ended = []
        machine.uc.hook_add(unicorn.UC_HOOK_BLOCK, self.block)
        # What has been translated before knows nothing of it.
        machine.uc.ctl_flush_tb()
        machine.after(TICK, self.tick, keep=True)

    def tick(self):
        if self.is_on:
            self.ended.append((self.counts, self.entries, self.copied))
            self.counts, self.entries, self.copied = (collections.Counter() for _ in range(3))
            self.machine.after(TICK, self.tick, keep=True)

    def block(self, uc, address, size, _):
        """Before a block is executed. The emulator's own counter, which came before, has counted it, unless it stops here."""
        now = self.machine.st.insn
        count = now - self.last
        if count == 0:
            return
        self.last = now
        active = self.machine.active
        # Tasks run in the main program and in an interrupt of their own.
        level = active[-1][0] if active else THREAD
        if len(active) > self.depth:
            self.entries[level] += self.is_on
        task, end = self.tasks.get(level, (level, None))
        if address == end:
            task, end = level, None
        elif address in self.polls:
            task, end = self.polls[address], uc.reg_read(arm.UC_ARM_REG_LR) & ~1
            self.entries[task] += self.is_on
        self.tasks[level] = task, end
        self.depth = len(active)
        if self.is_on:
            self.counts[task, address, size] += count
            if address in self.copies:
                size = uc.reg_read(arm.UC_ARM_REG_R1 if self.copies[address] else arm.UC_ARM_REG_R2)
                self.copied[uc.reg_read(arm.UC_ARM_REG_LR) & ~1, size] += 1

    def tables(self, wanted, only_worst):
        """Instructions of a tick, by who, by what and by function of the image, the largest first."""
        who_of, parts_of, functions = collections.Counter(), collections.Counter(), collections.Counter()
        worst = max(self.ended, key=lambda tick: tick[0].total())
        told = [worst] if only_worst else self.ended
        counts, came, copies = (sum(each, collections.Counter()) for each in zip(*told))
        blocks = {key: instructions(self.machine, *key[1:]) for key in counts}
        copied = collections.Counter()
        for (caller, size), count in copies.items():
            copied[f"{size} bytes for {self.machine.sym(caller).split(' ', 1)[-1].rsplit('+', 1)[0]}"] += count * size
        entries = collections.Counter()
        for who, count in came.items():
            entries[name_of(who)] += count
        known = symbols(self.image, sorted({address for found in blocks.values() for address in found}))
        parts = {address: part(stack) for address, stack in known.items()}
        for key, count in counts.items():
            who, address = name_of(key[0]), key[1]
            if wanted not in who:
                continue
            who_of[who] += count
            functions[self.machine.sym(address).split(" ", 1)[-1].rsplit("+", 1)[0]] += count
            for each in blocks[key]:
                parts_of[parts[each]] += count / len(blocks[key])
        a_tick = lambda counter: {name: count / len(told) for name, count in counter.most_common()}
        return {
            "mean": sum(who_of.values()) / len(told),
            "worst": worst[0].total(),
            "by who": a_tick(who_of),
            "times": a_tick(entries),
            "by what": a_tick(parts_of),
            "by function": a_tick(functions),
            "copied bytes": a_tick(copied),
        }


def task_polls(machine, image):
    """Of each task's poll function: where it begins, and the task's name."""
    found = {}
    starts = [(start, size) for start, size, name in machine.funcs if "TaskStorage" in name and "poll" in name]
    for start, size in starts:
        frames = symbols(image, range(start, start + size, 2))
        # The macro makes of `async fn measure` a `__measure_task`.
        names = [re.search(r"__(\w+?)_task::_", function) for stack in frames.values() for function, _ in stack]
        names = collections.Counter(match[1] for match in names if match)
        found[start] = "task " + names.most_common(1)[0][0].strip("_") if names else f"task {start:x}"
    return found


def copiers(machine):
    """Where copying begins, and whether the length is the second argument, as of the run-time ABI's memset and memclr, or the third."""
    names = [(start, name) for start, _, name in machine.funcs if re.match(r"(__aeabi_)?mem(cpy|set|move|clr)\d?$", name)]
    return {start: bool(re.match(r"__aeabi_mem(set|clr)", name)) for start, name in names}


def symbols(image, addresses):
    """Of each address its functions and files, innermost first."""
    said = subprocess.run(
        ["addr2line", "-afiC", "-e", image], input="\n".join(map(hex, addresses)), capture_output=True, text=True, check=True
    ).stdout.splitlines()
    found, stack, i = {}, None, 0
    while i < len(said):
        if said[i].startswith("0x"):
            stack = found.setdefault(int(said[i], 16), [])
            i += 1
        else:
            stack.append((said[i], said[i + 1].rsplit(":", 1)[0]))
            i += 2
    return found


def instructions(machine, address, size):
    """Where the block's instructions begin."""
    code, at, found = bytes(machine.uc.mem_read(address, size)), 0, []
    while at < size:
        found.append(address + at)
        at += 4 if code[at + 1] >> 3 >= 0x1D else 2
    return found


def part(stack):
    for function, file in stack:
        for name, pattern in PARTS:
            if re.search(pattern, file) or re.search(pattern, function):
                return name
    return "other"


def name_of(who):
    if who == SAMPLING:
        return "executor, sampling"
    names = {16 + 31: "I2C1 events", 16 + 32: "I2C1 errors", 16 + 39: "USART3", 16 + 67: "USB", 16 + 50: "TIM5 (time)"}
    if isinstance(who, int):
        dma = {11 + i: f"DMA1 stream {i}" for i in range(7)} | {56 + i: f"DMA2 stream {i}" for i in range(5)}
        return "interrupt: " + (names.get(who) or dma.get(who - 16) or str(who - 16))
    return who


def start(arguments):
    """A robot that drives, with everybody on the link."""
    machine = set_up(argparse.Namespace(image=arguments.image, absent=[], silent_servo=[]))
    Sensor(machine, "mpu9250")
    host, node = Host(machine), Node(machine)
    run(machine, SETTLED_S)
    upload(machine, host)

    def drive():
        node.command(*DRIVE)
        machine.after(100 * MS, drive, keep=True)

    def read_block():
        node.queue.append(packet(2, struct.pack("<HH", *BLOCK)))
        machine.after(50 * MS, read_block, keep=True)

    drive()
    if not arguments.quiet:
        read_block()
        Recorder(machine, host)
    run(machine, WARM_S)
    return machine


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("image")
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument("--quiet", action="store_true")
    parser.add_argument("--worst", action="store_true", help="only of the tick that took the most")
    parser.add_argument("--functions", type=int, default=0)
    parser.add_argument("--task", default="", help="only of tasks and interrupts whose name has this in it")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    machine = start(arguments)
    profile = Profile(machine, arguments.image)
    run(machine, arguments.seconds)
    profile.is_on = False
    found = profile.tables(arguments.task, arguments.worst)
    if arguments.json:
        print(json.dumps(found))
        return
    print(f"instructions in 5 ms: {found['mean']:.0f}, at most {found['worst']}")
    for table in ("by who", "by what", "by function", "copied bytes"):
        print(f"\n{table}")
        for name, count in list(found[table].items())[: None if table.startswith("by w") else arguments.functions]:
            times = f", {found['times'][name]:.1f} times" if table == "by who" and name in found["times"] else ""
            print(f"{count:9.0f}  {name}{times}")


if __name__ == "__main__":
    main()

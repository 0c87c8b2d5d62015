"""The real client of ROS 2's turtlebot3_node, its sources built without ROS, started before the board's link is there.

    git clone https://github.com/ROBOTIS-GIT/DynamixelSDK; git clone https://github.com/ROBOTIS-GIT/turtlebot3
    cargo build --release -p host-tools --bin gmr
    cargo build --release -p firmware --features virtual --bin virtual --target thumbv7em-none-eabihf
    python3 tests/system/node_starts.py DynamixelSDK turtlebot3 target/release/gmr target/thumbv7em-none-eabihf/release/virtual [--starts 20]

The node waits 34 ms for an answer, and ends where the first question has none. Each start: a new board, the node's wrapper of ROBOTIS's library
(node_starts.cpp), its first question, its start of the gyroscope's calibration, then its block 20 times a second and its heartbeat. Every call
has to be answered, and the block has to hold gravity. Needs a C++ compiler.
"""
import argparse
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
# All that the wrapper wants of ROS is a log.
LOG = "#include <cstdio>\n" + "".join(
    f"#define RCUTILS_LOG_{level}_NAMED(name, ...) (fprintf(stderr, __VA_ARGS__), fputc('\\n', stderr))\n" if level == "ERROR"
    else f"#define RCUTILS_LOG_{level}_NAMED(name, ...) ((void)0)\n"
    for level in ("DEBUG", "INFO", "WARN", "ERROR")
)


def built(arguments, folder):
    """The client."""
    os.makedirs(os.path.join(folder, "rcutils"))
    with open(os.path.join(folder, "rcutils/logging_macros.h"), "w") as file:
        file.write(LOG)
    sdk = os.path.join(arguments.sdk, "c++")
    node = os.path.join(arguments.turtlebot3, "turtlebot3_node")
    library = os.path.join(sdk, "src/dynamixel_sdk")
    sources = [os.path.join(library, name) for name in sorted(os.listdir(library)) if name.endswith(".cpp")]
    sources += [os.path.join(node, "src/dynamixel_sdk_wrapper.cpp"), os.path.join(HERE, "node_starts.cpp")]
    includes = [f"-I{path}" for path in (f"{sdk}/include", f"{sdk}/include/dynamixel_sdk", f"{node}/include", folder)]
    client = os.path.join(folder, "client")
    subprocess.run(["c++", "-std=c++17", "-O1", "-w", *includes, *sources, "-o", client, "-lpthread"], check=True)
    return client


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("sdk")
    parser.add_argument("turtlebot3")
    parser.add_argument("gmr")
    parser.add_argument("image")
    parser.add_argument("--starts", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=4.0)
    arguments = parser.parse_args()
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        client, link = built(arguments, folder), os.path.join(folder, "node")
        for _ in range(arguments.starts):
            line = [arguments.gmr, "board", "--realtime", "--profile", "none", "--duration", "3600", "--node", link, "--image", arguments.image]
            board = subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            ended = subprocess.run([client, link, str(arguments.seconds)]).returncode
            if ended:
                print(f"ended with {ended}", flush=True)
            failed += ended != 0
            board.kill()
            board.wait()
            if os.path.islink(link):
                os.remove(link)
    print(f"{arguments.starts} starts, {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()

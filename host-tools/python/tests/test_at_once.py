"""Calls at the same time do not mix."""

from concurrent.futures import ThreadPoolExecutor

import pytest

import wheelwatt

BAGS = [f"host-tools/formats/tests/data/{name}" for name in ("drive.mcap", "second.mcap")]
ROBOT = """\
name = "TurtleBot3 Burger"
kinematics = "differential"
wheel_radius_m = 0.033
track_m = 0.160
mass_no_load_kg = 1.0
mass_full_load_kg = 6.0
[topics]
power = "{}"
"""


@pytest.fixture
def robots(tmp_path):
    """Two robots by their topics of power."""
    paths = {}
    for topic in ("/power:data", "/total_mass:data"):
        paths[topic] = tmp_path / f"{len(paths)}.toml"
        paths[topic].write_text(ROBOT.format(topic))
    return paths


def test_each_call_reads_by_its_own_robot(robots):
    """A thousand pairs of the same bags by two robots: each says what it says alone."""

    def asked(place):
        robot, bag = robots[list(robots)[place % 2]], BAGS[place // 2 % 2]
        return wheelwatt.inspect(bag, robot=robot, plot=False).json()

    alone = [asked(place) for place in range(4)]
    assert len(set(alone)) == 4
    with ThreadPoolExecutor(2) as threads:
        for place, found in enumerate(threads.map(asked, range(2000))):
            assert found == alone[place % 4]

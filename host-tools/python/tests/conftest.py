"""What the tests share: the command beside the module, and short simulated drives."""

import os
import subprocess

import pytest

import wheelwatt


@pytest.fixture(scope="session")
def command():
    """Runs the command gmr; gives what it prints."""
    program = os.environ["GMR"]

    def run(*arguments, code=0):
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == code, done.stderr
        return done.stdout if code == 0 else done.stderr

    return run


@pytest.fixture(scope="session")
def drives(tmp_path_factory):
    """Two payloads to fit to, and a third to find: 20 Hz, as short as the models allow."""
    folder = tmp_path_factory.mktemp("drives")
    paths = []
    for name, mass, seed in [("empty", "1", 1), ("full", "6", 2), ("between", "3", 3)]:
        log = wheelwatt.simulate(duration=40, rate=20, mass=mass, seed=seed)
        paths.append(folder / f"{name}.csv")
        log.save(paths[-1])
    return paths


@pytest.fixture(scope="session")
def fitted(drives):
    """Eq. 18: solved at once, where the signed model tries several forms."""
    return wheelwatt.fit(drives[:2], model="eq18")

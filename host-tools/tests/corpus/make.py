"""What some two hundred calls of gmr print and write, so that two builds can be compared byte for byte.

    make.py make GMR FOLDER     runs every call with the program GMR; FOLDER has to be new
    make.py compare A B         says which calls differ; exit code 1 if any does

Inputs do not depend on the program: they are made here, or are files of host-tools/formats/tests/data. Each call leaves a folder with
stdout, stderr, the exit code and every file that it wrote. Paths of the working folder, the time that work took and the version of the
program are replaced. The calls are in calls.py.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# No file beside the sources.
sys.dont_write_bytecode = True

import calls  # noqa: E402


#: Seconds that one call may take.
LIMIT_S = 300
#: Calls that take longer are said.
SLOW_S = 10

#: What differs from run to run of one program.
CHANGING = [
    # How long work took: in JSON, behind a solver's steps, and in a column of compare's table.
    (re.compile(rb'("(?:fit|reading|filter|sums|sums_kept|judging|page|all_logs)_s": )[0-9.e+-]+'), rb"\1<seconds>"),
    (re.compile(rb'("seconds": )[0-9.e+-]+'), rb"\1<seconds>"),
    (re.compile(rb"(steps in )[0-9.]+ s"), rb"\1<seconds>"),
    (re.compile(rb"(, median) +[0-9.]+ s  slowest [0-9.]+ s"), rb"\1 <seconds>"),
    (re.compile(rb" +[0-9]+\.[0-9]{3} +(?=\S+ +(?:1 s|1 sample|plan)\b)"), b" <seconds> "),
    # A temporary file's own name.
    (re.compile(rb"\.gmr-\w+(\.tmp)?"), b".gmr-<name>"),
    # The program's.
    (re.compile(rb"\bgmr 0\.\d+\.\d+\b"), b"gmr <version>"),
]


def normalised(content: bytes, folder: Path) -> bytes:
    for path in {str(folder), os.path.realpath(folder)}:
        content = content.replace(path.encode(), b"<folder>")
    for pattern, text in CHANGING:
        content = pattern.sub(text, content)
    return content


def stamps(folder: Path) -> dict[Path, tuple[int, int]]:
    """When each file was written, and how long it is."""
    found = {}
    for path in folder.rglob("*"):
        if path.is_file():
            status = path.stat()
            found[path.relative_to(folder)] = (status.st_mtime_ns, status.st_size)
    return found


def make(program: Path, results: Path) -> None:
    program = program.resolve()
    results.mkdir(parents=True)
    with tempfile.TemporaryDirectory(prefix="corpus-") as kept:
        folder = Path(kept)
        calls.inputs(folder)
        # The nearest robot.toml is that of the folder itself, if any.
        environment = {"PATH": os.environ["PATH"], "HOME": kept, "TMPDIR": kept, "COLUMNS": "100", "LC_ALL": "C.UTF-8"}
        for place, (name, arguments) in enumerate(calls.CALLS):
            before = stamps(folder)
            begun = time.monotonic()
            ended = subprocess.run(
                [program, *arguments], cwd=folder, env=environment, capture_output=True, stdin=subprocess.DEVNULL, timeout=LIMIT_S
            )
            if time.monotonic() - begun > SLOW_S:
                print(f"{time.monotonic() - begun:.0f} s: gmr {' '.join(arguments)}", flush=True)
            own = results / f"{place:03}-{name}"
            own.mkdir()
            (own / "call").write_text("gmr " + " ".join(arguments) + "\n")
            (own / "code").write_text(f"{ended.returncode}\n")
            (own / "stdout").write_bytes(normalised(ended.stdout, folder))
            (own / "stderr").write_bytes(normalised(ended.stderr, folder))
            after = stamps(folder)
            for path in sorted(path for path in after if after[path] != before.get(path)):
                to = own / "files" / path
                to.parent.mkdir(parents=True, exist_ok=True)
                to.write_bytes(normalised((folder / path).read_bytes(), folder))
            gone = sorted(str(path) for path in before.keys() - after.keys())
            if gone:
                (own / "gone").write_text("\n".join(gone) + "\n")
    print(f"{len(calls.CALLS)} calls in {results}")


def compare(first: Path, second: Path) -> int:
    def content(folder: Path) -> dict[Path, bytes]:
        return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    one, other = content(first), content(second)
    differing = sorted(path for path in one.keys() | other.keys() if one.get(path) != other.get(path))
    for path in differing:
        what = "differs" if path in one and path in other else f"only in {first if path in one else second}"
        print(f"{path}: {what}")
    called = {path.parts[0] for path in differing}
    print(f"{len(called)} calls of {len({path.parts[0] for path in one.keys() | other.keys()})} differ")
    return 1 if differing else 0


def main() -> int:
    match sys.argv[1:]:
        case ["make", program, folder]:
            make(Path(program), Path(folder))
            return 0
        case ["compare", first, second]:
            return compare(Path(first), Path(second))
        case _:
            print(__doc__)
            return 2


if __name__ == "__main__":
    sys.exit(main())

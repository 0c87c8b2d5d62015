from collections.abc import Callable
from os import PathLike
from typing import Any

def main(arguments: list[str]) -> int: ...
def run(
    arguments: list[str], progress: Callable[[str, int, int], Any] | None = None
) -> tuple[str, list[str]]: ...
def read_log(
    path: str | PathLike[str],
) -> tuple[list[str], list[bytes], list[str], list[int], str]: ...
def write_log(
    path: str | PathLike[str],
    names: list[str],
    columns: list[bytes],
    runs: list[str] | None,
) -> None: ...
def gram_columns() -> tuple[list[str], list[tuple[str, str]]]: ...
def gram_of_columns(
    arguments: list[str],
    column_names: list[str],
    columns: list[bytes],
    runs: list[str] | None,
) -> list[tuple[list[str], list[float]]]: ...
def write_grams(path: str | PathLike[str], rows: list[tuple[list[str], list[float]]]) -> None: ...

from os import PathLike

def run(arguments: list[str]) -> tuple[str, list[str]]: ...
def read_log(
    path: str | PathLike[str],
) -> tuple[list[str], list[bytes], list[str], list[int], str]: ...
def write_log(
    path: str | PathLike[str],
    names: list[str],
    columns: list[bytes],
    runs: list[str] | None,
) -> None: ...

"""What went wrong, and where."""

from __future__ import annotations


class Error(Exception):
    """Something that the caller can mend: ``str`` says place, what was found, and what was expected.

    Attributes
    ----------
    message : what was found and expected, without its place
    file : path of the file, or the name of the `Log`; None where it is about none
    line : its line, from 1 with the header; None where it is about none
    column : its column, or the key of a description
    exit_code : what the command ends with: 1 failed, 2 wrong usage
    """

    def __init__(
        self,
        message: str,
        file: str | None = None,
        line: int | None = None,
        column: str | None = None,
        exit_code: int = 1,
    ) -> None:
        super().__init__(message, file, line, column, exit_code)
        self.message = message
        self.file = file
        self.line = line
        self.column = column
        self.exit_code = exit_code

    def __str__(self) -> str:
        place = [str(part) for part in (self.file, self.line, self.column) if part is not None]
        return ": ".join([":".join(place), self.message] if place else [self.message])


class NotForBoards(Error):
    """Coefficients that no board would take: the figures of their fit are there, the coefficients are not."""

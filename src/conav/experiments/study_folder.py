"""The folder of a reproduction: its page, its tables, and numbers that are in range."""

import csv
import io
from collections.abc import Callable, Iterable, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

from conav.errors import InputError
from conav.pictures.output import whole_file

PAGE = "README.md"


def made_folder(folder: Path, title: str) -> Path:
    """The folder, which is made. A page in it that does not begin with the title is not touched.

    Raises `InputError` for such a page, and for a folder that cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        page = folder / PAGE
        strange = page.exists() and not page.read_bytes().startswith(title.encode())
    except OSError as error:
        raise InputError(
            folder, f"cannot be made ({error.strerror})", "give another --out"
        ) from None
    if strange:
        raise InputError(folder, f"holds a {PAGE} of something else", "give another --out")
    return folder


def in_range(name: str, value: float, least: float, most: float) -> None:
    """Raises `InputError` for a number that is not between the two."""
    if not least <= value <= most:
        raise InputError(f"{name} {value:g}", "is out of range", f"give {least:g} to {most:g}")


def drawn(draw: Callable[[], None], warnings: list[str]) -> None:
    """Draws pictures, or remembers once why not: there is no matplotlib."""
    try:
        draw()
    except InputError as error:
        if "matplotlib" not in error.problem:
            raise
        text = f"no plots: {error.problem.partition(' needs ')[2]}; {error.remedy}"
        if text not in warnings:
            warnings.append(text)


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Writes a table, whole or not at all; numbers that are not finite are left empty."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(header)
    for row in rows:
        table.writerow([_cell(value) for value in row])
    with whole_file(path) as stream:
        stream.write(text.getvalue().encode())


def _cell(value: Any) -> Any:
    if isinstance(value, float):
        return f"{value:.6g}" if isfinite(value) else ""
    return value

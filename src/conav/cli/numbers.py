"""Numbers on the command line."""

from collections.abc import Sequence
from typing import Annotated, Any

from cyclopts import Parameter


def whole(kind: Any, tokens: Sequence[Any]) -> int:
    """The whole number a token is. Raises `ValueError` for anything else, 1.5 included.

    Without it "1.5" would be rounded silently.
    """
    text = str(tokens[0].value)
    try:
        return int(text)
    except ValueError:
        raise ValueError(f'"{text}" is not a whole number') from None


Whole = Annotated[int, Parameter(converter=whole)]

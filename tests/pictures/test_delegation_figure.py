"""The picture of the delegation protocol is that of the program's tables."""

import re
from collections import Counter
from pathlib import Path

from conav.pictures import delegation_figure as module
from conav.pictures.delegation_figure import in_box, save_delegation, transitions
from conav.pursuit.delegation_tables import ASKING, HELPING, Asking, Helping


def test_every_transition_is_drawn() -> None:
    drawn = Counter(
        (state, event, then) for (state, then), events in transitions().items() for event in events
    )
    tables = [*ASKING.items(), *HELPING.items()]
    assert drawn == Counter((state, event, then) for (state, event), then in tables)
    assert set(module.PLACES) == {*Asking, *Helping}
    assert any(in_box(*ends) for ends in transitions())
    assert not all(in_box(*ends) for ends in transitions())


def test_the_words_of_the_picture(tmp_path: Path) -> None:
    save_delegation(tmp_path / "a.svg")
    save_delegation(tmp_path / "b.svg")
    # matplotlib keeps each text as a comment beside its outlines.
    words = " ".join(re.findall(r"<!-- (.*?) -->", (tmp_path / "a.svg").read_text(), re.DOTALL))
    for state in (*Asking, *Helping):
        assert state in words
    for _, event in (*ASKING, *HELPING):
        assert event in words
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()

"""The studies of clearing floors: what they measure is what it must be."""

from conav.experiments.pursuit.graph_size import graph_sizes
from conav.experiments.pursuit.message_cost import messages_by_team_size, round_bound
from conav.experiments.pursuit.orders import orders_and_losses


def test_messages_grow_with_the_team_and_keep_to_the_bound() -> None:
    rows = messages_by_team_size("spider:2,2,2", (1, 3, 6, 9))
    assert all(row.captured for row in rows)
    assert [row.pursuers for row in rows] == [2, 3, 6, 9]
    for row in rows:
        assert row.deliberations <= row.rounds
        assert row.longest_round <= round_bound(row.pursuers)
        assert row.messages <= row.rounds * row.longest_round
        assert row.size_bytes > 24 * row.messages
    # One more idle pursuer: roles asked and told, help asked and answered, an offer not taken.
    assert rows[3].longest_round - rows[2].longest_round == 5 * 3


def test_parts_have_small_graphs() -> None:
    whole, split = graph_sizes(["comb:4", "spider:2,2,2"])
    assert (whole.guards, whole.parts) == (0, 1)
    assert whole.parts_total == whole.parts_largest == whole.whole
    assert (split.guards, split.parts) == (1, 3)
    assert split.parts_largest < split.parts_total < split.whole
    (paper,) = graph_sizes(["spider:2,2,2"], "paper")
    assert paper.complete
    assert paper.vertices == split.vertices
    assert paper.parts_total < paper.whole
    for labels in ("shadows", "paper"):
        (cut,) = graph_sizes(["comb:4"], labels, limit=20)
        assert not cut.complete
        assert cut.whole == 20


def test_parallel_is_quicker_and_losses_are_made_good() -> None:
    rows = orders_and_losses(["spider:2,2,2"])
    assert [(row.order, row.lost_s is not None) for row in rows] == [
        ("sequence", False),
        ("sequence", True),
        ("parallel", False),
        ("parallel", True),
    ]
    assert all(row.captured for row in rows)
    alone, alone_lost, at_once, at_once_lost = rows
    assert at_once.time_s < alone.time_s
    assert at_once.pursuers > alone.pursuers
    for whole, lost in ((alone, alone_lost), (at_once, at_once_lost)):
        assert whole.recontaminated_m2 == 0.0
        assert lost.recontaminated_m2 > 0.0
        assert lost.time_s > whole.time_s
        assert lost.pursuers == whole.pursuers + 1
    # Nobody stands guard: the one who clears is lost, and nothing that was clear is contaminated.
    _, lost, _, _ = orders_and_losses(["comb:3"])
    assert lost.captured
    assert lost.recontaminated_m2 == 0.0

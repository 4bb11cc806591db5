"""Link budgets by hand, and radios that cannot be."""

from math import log10

import pytest

from conav.robots.radio import PathLoss, Radio, radio


def test_loss_by_hand() -> None:
    model = PathLoss(unit_m=1.0)
    assert model.loss_db(10.0, 0.0) == 31.0  # nearer than d0 nothing is added
    assert model.loss_db(35.0, 0.0) == 31.0
    assert model.loss_db(350.0, 0.0) == 51.0
    assert model.loss_db(10.0, 10.0) == 71.0
    assert model.loss_db(350.0, 100.0) == 131.0
    assert model.loss_db(10.0, 0.5) == 31.0  # a thin wall does not help
    assert PathLoss(unit_m=1.0, wall_shadow_db=3.0).loss_db(10.0, 0.5) == 34.0
    assert PathLoss(unit_m=1.0, free_shadow_db=2.0).loss_db(350.0, 0.0) == 53.0
    assert PathLoss(unit_m=0.1).loss_db(35.0, 1.0) == 91.0


def test_reach_ends_where_fifty_decibels_are_lost() -> None:
    model = PathLoss(unit_m=0.1)
    free = 3.5 * 10**0.95  # 31 + 20 log10(d / d0) = 50
    assert model.reaches(free - 0.01, 0.0)
    assert not model.reaches(free + 0.01, 0.0)
    wall = 0.1 * 10**0.475  # 31 + 40 log10(d) = 50
    assert model.reaches(1.0, wall - 0.001)
    assert not model.reaches(1.0, wall + 0.001)
    # Exactly at the threshold there is no link.
    assert not PathLoss(reference_db=50.0).reaches(1.0, 0.0)
    assert log10(10.0) == 1.0


def test_radios_by_name() -> None:
    assert radio("path-loss", loss=0.1, delay_s=2.0) == Radio(
        "path-loss", None, PathLoss(), 0.1, 2.0
    )
    assert radio("limited", 0.0).name == "off"
    with pytest.raises(ValueError, match="no radio"):
        radio("limited")
    for loss in (-0.1, 1.0, float("nan")):
        with pytest.raises(ValueError, match="loses"):
            radio("perfect", loss=loss)
    for delay in (-1.0, float("inf"), float("nan")):
        with pytest.raises(ValueError, match="delay"):
            radio("perfect", delay_s=delay)

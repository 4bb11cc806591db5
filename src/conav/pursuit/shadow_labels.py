"""Labels of shadows for a pursuit graph: what is called clear is clear."""

from dataclasses import dataclass

from conav.pursuit.shadow_moves import Point, ShadowMoves


@dataclass
class ShadowLabels:
    """Which shadows of a team may hold somebody, one bit each, as `ShadowMoves` numbers them."""

    shadows: ShadowMoves

    def begin(self, team: tuple[Point, ...]) -> int:
        """All shadows of a standing team, as bits."""
        return (1 << self.shadows.shadows(team).count) - 1

    def after(self, others: tuple[Point, ...], a: Point, b: Point, contaminated: int) -> int:
        """The shadows that may hold somebody after one pursuer drove from a to b, as bits.

        The others stand.
        """
        return self.shadows.after(others, a, b, contaminated)

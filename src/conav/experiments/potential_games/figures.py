"""Figures 3 and 6 of [Philip2014], and the coordinated team against the uncoordinated ones."""

from conav.experiments.potential_games.lab import (
    Lab,
    finished_share,
    mean_times,
    time_ratio,
)
from conav.experiments.potential_games.report import (
    HELD,
    NOT_HELD,
    OPEN,
    Section,
    above,
    below,
    estimate,
    every,
    percent,
)
from conav.experiments.potential_games.teams import (
    TIES,
    TIME_HEADER,
    TIMES,
    add_coverage,
    add_times,
    algorithm_2,
    alone,
    draw_coverage,
    improved,
    uncoordinated,
)
from conav.intervals import Estimate, mean_interval
from conav.pictures.plots import Series


def figure_3(lab: Lab) -> Section:
    """Exploration time against the sensor's range."""
    section = Section(
        "figure-3",
        "Figure 3: the sensor's range",
        "Algorithm 2 with epsilon 0.3 and sRange 2, 3 and 4, with both rules for ties.",
        TIME_HEADER,
    )
    for tie, text in TIES:
        teams = [algorithm_2(0.3, tie, s_range) for s_range in (2, 3, 4)]
        played = [lab.bulk(one) for one in teams]
        for one, games in zip(teams, played, strict=True):
            add_times(section, lab, one, games)
        if tie == "random":
            pairs = list(zip(teams, played, strict=True))
            series = add_coverage(section, lab, pairs, 1500)
            series = [
                Series(f"sRange {one.s_range}", line.x, line.y, line.low, line.high)
                for one, line in zip(teams, series, strict=True)
            ]
            draw = draw_coverage(series, "Algorithm 2, epsilon 0.3")
            section.pictures.append(("figure-3.png", "Points seen against time, by range", draw))
        ratios = [time_ratio(played[k + 1], played[k], 3, lab.steps) for k in (0, 1)]
        verdict = every([below(ratio, 1.0) for ratio in ratios])
        section.judge(
            "Figure 3",
            f"exploration time falls with sRange ({text})",
            verdict,
            f"T100 at sRange 3 over 2: {estimate(ratios[0])}; 4 over 3: {estimate(ratios[1])}",
        )
        means = [mean_times(one, 3, lab.steps) for one in played]
        gains = [(two - three) - (three - four) for two, three, four in zip(*means, strict=True)]
        lost = mean_interval(gains)
        section.add(f"potential, {text}", 0, "T100 gain 2 to 3 less gain 3 to 4", "steps", lost)
        section.judge(
            "Figure 3",
            f"the improvement becomes smaller with sRange ({text})",
            above(lost, 0.0),
            f"T100 saved from 2 to 3, less that from 3 to 4: {estimate(lost)} steps",
        )
    return section


def figure_6(lab: Lab) -> Section:
    """Algorithm 2 against the improved algorithm."""
    section = Section(
        "figure-6",
        "Figure 6: Algorithm 2 against the improved algorithm",
        "sRange 2, epsilon 0.1, 2,000 steps; 20 games per layout as in the paper, and more. Points "
        "are what robots truly saw.",
        TIME_HEADER,
    )
    for games in sorted({20, lab.games}):
        for tie, text in TIES:
            teams = [algorithm_2(0.1, tie), improved(0.1, tie)]
            played = [lab.bulk(one, games=games, steps=2000) for one in teams]
            if games == lab.games:
                for one, found in zip(teams, played, strict=True):
                    done = finished_share(found, 3)
                    section.add(one.label, 2, "finished within 2,000 steps", "share of games", done)
                full = [lab.bulk(one) for one in teams]
                for one, found in zip(teams, full, strict=True):
                    add_times(section, lab, one, found)
                    out = mean_interval([100 * layout.left_out for layout in found])
                    section.add(one.label, 2, "left out at the end", "% of points", out)
                ratio = time_ratio(full[1], full[0], 3, lab.steps)
                section.add(f"Improved over Algorithm 2, {text}", 2, "T100 ratio", "", ratio)
                within = ratio.low > 1 / 1.05 and ratio.high < 1.05
                section.judge(
                    "Figure 6",
                    f"the total time is the same ({text})",
                    HELD if within else OPEN if ratio.low <= 1 <= ratio.high else NOT_HELD,
                    f"T100 of Improved over Algorithm 2: {estimate(ratio)} (held: within 5 %)",
                )
            if tie == "random" and games == lab.games:
                pairs = list(zip(teams, played, strict=True))
                series = add_coverage(section, lab, pairs, 1200)
                draw = draw_coverage(series, "sRange 2, epsilon 0.1")
                section.pictures.append(("figure-6.png", "Points seen against time", draw))
            gains: list[Estimate] = []
            for step in (100, 200, 300, 400, 500, 600, 700, 1000, 1500):
                points = [
                    (b.coverage[step] - a.coverage[step]) * a.observable
                    for a, b in zip(*played, strict=True)
                ]
                gain = mean_interval(points)
                label = f"Improved less Algorithm 2, {text}, {games} games"
                section.add(label, 2, f"points seen at step {step}", "points", gain)
                if 200 <= step <= 700:
                    gains.append(gain)
            section.judge(
                "Figure 6",
                f"Improved has seen more from step 200 to 700 ({text}, {games} games)",
                every([above(gain, 0.0) for gain in gains]),
                f"points more at step 200: {estimate(gains[0])}, 400: {estimate(gains[2])}, 700: "
                f"{estimate(gains[5])}",
            )
    return section


def coordination(lab: Lab) -> Section:
    """Algorithm 2 against both uncoordinated teams."""
    section = Section(
        "coordination",
        "Coordinated against uncoordinated",
        "Uncoordinated is Algorithm 2 with epsilon 1 (section 2.4). Whether such robots share what "
        "they discover is not said, so both readings are played.",
        TIME_HEADER,
    )
    for tie, _ in TIES:
        rivals = [uncoordinated(tie), alone(tie)]
        teams = [algorithm_2(0.1, tie), algorithm_2(0.3, tie), *rivals]
        played = [lab.bulk(one) for one in teams]
        for one, games in zip(teams, played, strict=True):
            add_times(section, lab, one, games)
        if tie == "random":
            series = add_coverage(section, lab, list(zip(teams, played, strict=True)), 2000)
            draw = draw_coverage(series, "Coordinated and uncoordinated, sRange 2")
            section.pictures.append(("coordination.png", "Points seen against time", draw))
        for k, rival in enumerate(rivals):
            for column in (0, 3):
                ratios = [
                    time_ratio(played[mine], played[2 + k], column, lab.steps) for mine in (0, 1)
                ]
                for mine, ratio in enumerate(ratios):
                    label = f"{teams[mine].label} over {rival.label}"
                    section.add(label, 2, f"{TIMES[column]} ratio", "", ratio)
                section.judge(
                    "section 3",
                    f"Algorithm 2 has the shorter {TIMES[column]} against: {rival.label}"
                    + ("" if tie == "baseline" else ", ties drawn"),
                    every([below(ratio, 1.0) for ratio in ratios]),
                    f"ratio at epsilon 0.1: {estimate(ratios[0])}; at 0.3: {estimate(ratios[1])}",
                )
    games = [finished_share(lab.bulk(algorithm_2(0.3, tie)), 3) for tie, _ in TIES]
    section.judge(
        "section 2.4",
        "with the literal rule for ties games end, as the paper's plots do",
        NOT_HELD if games[1].high < 0.5 else OPEN,
        f"finished within {lab.steps} steps: {percent(games[1])}; ties drawn: {percent(games[0])}",
    )
    return section

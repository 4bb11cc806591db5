"""A scene, or a plan for it, as one picture."""

import os
from collections.abc import Sequence

from conav.errors import InputError
from conav.pictures.canvas import ColourCanvas
from conav.pictures.footer import MIN_WIDTH, Footer, plain_name
from conav.pictures.output import checked_path, checked_pixels, whole_file
from conav.pictures.palette import Colours
from conav.pictures.plan_scene import PlanScene, PlanView, plan_view, tick_s
from conav.planning.trajectory import end_position, polyline
from conav.planning.types import PlanningProblem, Trajectory


def save_plan_picture(
    problem: PlanningProblem,
    path: str | os.PathLike[str],
    trajectories: Sequence[Trajectory | None] = (),
    *,
    words: str = "",
    max_pixels: int = 1600,
) -> None:
    """Draw a scene to a PNG at most `max_pixels` on a side; with trajectories, a plan.

    Robots and their own regions have a colour each. A ring is where a robot starts, a disc where it
    stops, a ring with a dot where it vanishes; dots on its way are equal times apart, as the footer
    says. Regions that several robots know are yellow; those to keep out of are hatched. `words`
    stand in the footer. Raises `InputError` for a path that cannot be written and for another
    number of trajectories than robots.
    """
    from PIL import Image

    target = checked_path(path, ".png", "a still picture")
    max_pixels = checked_pixels(max_pixels)
    given = checked_trajectories(problem, trajectories)
    every_s = tick_s(given)
    driven = any(item is not None for item in given)
    parts = [words] if words else []
    state = " · ".join([*parts, f"a dot every {every_s:g} s"] if driven else parts)
    view, footer = framed(problem, state, max_pixels)
    colours = Colours(len(problem.robots))
    canvas = ColourCanvas(view.page_width, view.height + view.footer_height, colours)
    scene = PlanScene(view, problem, colours)
    scene.paint_ground(canvas)
    for robot, trajectory in enumerate(given):
        if trajectory is not None:
            scene.drive(robot, polyline(trajectory, 0.3 / view.pixels_per_m)[:, :2])
    scene.paint_ways(canvas)
    for robot, trajectory in enumerate(given):
        if trajectory is not None:
            scene.paint_ticks(canvas, robot, trajectory, every_s)
    scene.paint_starts(canvas)
    parked: list[int] = []
    for robot, trajectory in enumerate(given):
        if trajectory is None:
            continue
        x, y = end_position(trajectory)
        if problem.robots[robot].after_arrival == "vanish":
            scene.paint_vanished(canvas, robot, x, y)
        else:
            scene.paint_robot(canvas, robot, x, y)
            parked.append(robot)
    scene.paint_labels(canvas, parked)
    footer.paint(canvas, view.height, state, view.pixels_per_m)
    with whole_file(target) as stream:
        Image.fromarray(canvas.pixels).save(stream, format="PNG", optimize=True)


def framed(problem: PlanningProblem, widest_state: str, max_pixels: int) -> tuple[PlanView, Footer]:
    """The view of a scene and the footer below it."""
    count = len(problem.robots)
    robots = f"{count} robots" if count > 1 else "1 robot"
    footer = Footer(f"{plain_name(problem.name)} · {robots}", widest_state)
    # A narrower page needs a higher footer, which makes the page narrower: twice is enough.
    view = plan_view(problem, max_pixels, MIN_WIDTH, footer.height(max_pixels))
    view = plan_view(problem, max_pixels, MIN_WIDTH, footer.height(view.page_width))
    return view, footer


def checked_trajectories(
    problem: PlanningProblem, trajectories: Sequence[Trajectory | None]
) -> list[Trajectory | None]:
    """One for each robot, None for those without. Raises `InputError` for another number."""
    if len(trajectories) not in (0, len(problem.robots)):
        raise InputError(
            f"{len(trajectories)} trajectories", f"the scene has {len(problem.robots)} robots",
            "give one for each, None for a robot without",
        )  # fmt: skip
    return list(trajectories) or [None] * len(problem.robots)

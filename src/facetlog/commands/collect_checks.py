"""Which options of `facetlog collect` go together, and what they say is driven."""

from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.commands.collect_explored import checked_goal, target_tour
from facetlog.commands.robot_options import numbers_in
from facetlog.errors import InputError

if TYPE_CHECKING:
    from facetlog.robot.collecting.route import Circle
    from facetlog.robot.collecting.tour_file import Tour
    from facetlog.stream import Goal

__all__ = [
    "asked_tour",
    "check_explored",
    "checked_explore",
    "checked_order",
    "circles_in",
    "where_it_stood",
]

ORDERS = ("given", "short")


def checked_order(order: str, *, explore: bool) -> bool:
    """Whether a tour's order is to be short; InputError for another word, or without a tour."""
    if order not in ORDERS:
        raise InputError(f"--order {order!r:.40}: use one of {', '.join(ORDERS)}")
    if explore and order != "given":
        raise InputError("--order is of a tour: leave it out with --explore")
    return order == "short"


def checked_explore(
    explore: bool,
    tour: str | None,
    target: str | None,
    until: str | None,
    most: int,
    keep_out: list[str] | None,
    dry: bool,
) -> "Goal | None":
    """The goal, if there is one; InputError for options that do not go together."""
    if not explore:
        if tour is None:
            raise InputError("give --tour CSV, or --explore --target X,Y,Z --keep-out RADIUS")
        alone = {"--target": target, "--until": until, "--dry-run": dry or None}
        for name in (name for name, value in alone.items() if value is not None):
            raise InputError(f"{name} goes with --explore")
        return None
    if tour is not None:
        raise InputError("--explore chooses the views itself: leave out --tour")
    if not dry:
        _check_target(target, keep_out)
    return checked_goal(until, most)


def check_explored(folder: Path) -> None:
    """InputError for a folder without a collection, of which --dry-run says what comes next."""
    from facetlog.robot.collecting.record import LOG_FILE

    if not (folder / LOG_FILE).is_file():
        raise InputError(f"{folder} holds no collection: --dry-run goes on from one")


def _check_target(target: str | None, keep_out: list[str] | None) -> None:
    """InputError that names all that is missing for the exploration of one target."""
    lacks = []
    if target is None:
        lacks.append("--target X,Y,Z (where what is looked at stands, metres)")
    if not keep_out:
        lacks.append("--keep-out RADIUS (how near the robot may come, metres)")
    if lacks:
        raise InputError(f"--explore needs {' and '.join(lacks)}")


def circles_in(given: list[str] | None) -> "float | tuple[Circle, ...] | None":
    """One radius about the target, or circles."""
    from facetlog.robot.collecting.route import Circle

    if not given:
        return None
    form = "RADIUS, or X,Y,RADIUS as often as needed (metres)"
    circles = []
    for text in given:
        numbers = numbers_in(text, "--keep-out", form, 1, 3)
        if numbers[-1] <= 0:
            raise InputError(f"--keep-out {text!r:.40}: a radius is above 0")
        if len(numbers) == 1 and len(given) == 1:
            return numbers[0]
        if len(numbers) == 1:
            raise InputError(f"--keep-out {text!r:.40}: of several, each is X,Y,RADIUS")
        circles.append(Circle(*numbers))
    return tuple(circles)


def _tour(name: str, scale: float | None) -> "Tour":
    from facetlog.robot.collecting.tour_file import PAPER_TOUR, paper_tour, read_tour

    return paper_tour() if name == PAPER_TOUR else read_tour(Path(name), unit=scale)


def asked_tour(tour: str | None, target: str | None, scale: float | None) -> "Tour":
    """Return the tour of a file or name, else one without views that looks at the target."""
    return target_tour(target) if tour is None else _tour(tour, scale)


def where_it_stood(folder: Path) -> str:
    """Where an earlier run left the robot, as a hint for --start."""
    from facetlog.robot.collecting.last_place import last_place
    from facetlog.robot.collecting.option_words import stated_pose

    try:
        last = last_place(folder)
    except InputError:
        last = None
    if last is None:
        return " (where it stood last is not recorded: measure it)"
    return f" ({last.how} {stated_pose(last.pose)})"

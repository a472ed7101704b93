"""The numbers that the paper prints, and the same computed by its recursion as printed."""

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from facetlog.perception.estimation.ekf import State
from facetlog.perception.estimation.plane_filter import Chart, plain_plane_recursion
from facetlog.perception.estimation.point_filter import run_printed_recursion
from facetlog.perception.pan_tilt import projection_matrix
from facetlog.perception.types import Observation


@dataclass(frozen=True, slots=True)
class Iteration:
    """One printed step: its inputs, and for each output (name, printed, computed with one more
    digit).
    """

    number: int
    given: str
    rows: tuple[tuple[str, str, str], ...]


@cache
def printed() -> dict[str, Any]:
    """Return the figures of section 5.3 as printed.toml has them."""
    return tomllib.loads(files(__package__).joinpath("printed.toml").read_text(encoding="utf-8"))


def point_iterations() -> tuple[Iteration, ...]:
    """Return the two iterations of the point filter."""
    paper = printed()["point"]
    cases = paper["iteration"]
    poses = [(*case["pose"], paper["focal"]) for case in cases]
    projections = [projection_matrix(x, y, z, *angles) for x, y, z, *angles in poses]
    seen = [Observation(k, case["uv"], paper["noise"] * np.eye(2)) for k, case in enumerate(cases)]
    start = State(np.zeros(3), paper["s0"] * np.eye(3))
    found = []
    states = run_printed_recursion(seen, projections, start)
    for number, (case, state) in enumerate(zip(cases, states, strict=True), start=1):
        u, v = case["printed_uv"]
        x, y, z, pan, tilt, _ = case["printed_pose"]
        given = f"(u, v) = ({u}, {v}), pinhole ({x}, {y}, {z}), A = {pan}, B = {tilt}, C = 0"
        rows = [
            _row(name, p, c, 2) for name, p, c in zip("xyz", case["point"], state.mean, strict=True)
        ]
        digits = 1 if case["cov_tolerance"] > 0.01 else 2
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
            name = f"S {'xyz'[i]}{'xyz'[j]}"
            rows.append(_row(name, case["cov"][i][j], float(state.cov[i, j]), digits))
        found.append(Iteration(number, given, tuple(rows)))
    return tuple(found)


def plane_iterations() -> tuple[Iteration, ...]:
    """Return the two iterations of the plane filter."""
    paper = printed()["plane"]
    cases = paper["iteration"]
    start = State(np.zeros(3), paper["s0"] * np.eye(3))
    points = [case["point"] for case in cases]
    states = plain_plane_recursion(points, paper["noise"] * np.eye(3), start, Chart.Z)
    return tuple(
        Iteration(
            number,
            f"(x, y, z) = {tuple(case['point'])}",
            tuple(
                _row(name, p, c, 3)
                for name, p, c in zip("abp", case["parameters"], state.mean, strict=True)
            ),
        )
        for number, (case, state) in enumerate(zip(cases, states, strict=True), start=1)
    )


def _row(name: str, given: float, computed: float, digits: int) -> tuple[str, str, str]:
    # One digit more than printed: two of the paper's figures are cut, not rounded.
    return name, f"{given:.{digits}f}", f"{computed + 0.0:.{digits + 1}f}"

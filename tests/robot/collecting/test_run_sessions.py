"""When and where the runs of a collection began, and where pictures placed their robot since."""

from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.robot.collecting.run_sessions import runs_of

FOLDER = Path("views")


def _run(began: float, *start: float) -> dict[str, object]:
    return {"schema": "facetlog-collect/1", "began": began, "start": list(start)}


@pytest.mark.parametrize("line", [{"schema": "x"}, {"schema": "x", "start": [1.0, 2.0]}])
def test_a_run_without_a_start_is_refused(line: dict[str, object]) -> None:
    with pytest.raises(InputError, match="does not say where a run began"):
        runs_of([line], FOLDER)

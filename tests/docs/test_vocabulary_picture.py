"""docs/pictures/vocabulary.svg: as the script draws it now, of words that there are."""

import runpy
from pathlib import Path

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "scripts" / "draw_vocabulary.py"


def test_the_picture_is_as_the_measures_are_now():
    assert runpy.run_path(str(SCRIPT))["main"](["--check"]) == 0

"""`facetlog mat`: the page that it writes, and what it says of pictures."""

import json
import re

import numpy as np
import pytest

from facetlog.cli import main
from facetlog.mat_sheet import draw_mat_figure
from facetlog.perception.reading.mat.mats import MATS
from tests.perception.reading.mat.mat_photos import around, photo, photos, write_photos

POINTS_PER_MM = 72 / 25.4


@pytest.mark.parametrize("mat", MATS, ids=lambda mat: mat.paper)
def test_the_page_is_as_large_as_its_paper(mat, tmp_path):
    out = tmp_path / "mat.pdf"
    assert main(["mat", "-o", str(out), "--paper", mat.paper]) == 0
    box = re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", out.read_bytes())
    assert box is not None
    size = [float(number) / POINTS_PER_MM for number in box.groups()]
    assert size == pytest.approx([mat.width_mm, mat.height_mm], abs=1e-6)


@pytest.mark.parametrize("mat", MATS, ids=lambda mat: mat.paper)
def test_words_and_bar_lie_on_the_page_and_below_the_board(mat):
    page = draw_mat_figure(mat)
    (axes,) = page.axes
    low = (mat.height_mm - mat.rows * mat.square_mm) / 2
    per_mm = page.dpi / 25.4
    (words,) = axes.texts
    assert mat.paper in words.get_text()
    for artist in (*axes.texts, *axes.lines):
        box = artist.get_window_extent()
        assert 5 < box.x0 / per_mm <= box.x1 / per_mm < mat.width_mm - 5
        assert 5 < box.y0 / per_mm <= box.y1 / per_mm < low
    assert axes.lines[0].get_xdata()[1] - axes.lines[0].get_xdata()[0] == pytest.approx(100.0)


@pytest.mark.parametrize(
    ("argv", "line"),
    [
        (["-o", "mat.pdf", "--paper", "A5"], "no mat for paper 'A5': use one of A4, A3, Letter"),
        ([], "give one, as -o mat.pdf"),
        (["-o", "no/mat.pdf"], "cannot be written"),
        (["-o", "mat.png"], "mat.png: a mat is a PDF"),
    ],
)
def test_what_cannot_be_written_is_said_in_one_line(argv, line, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["mat", *argv]) == 2
    err = capsys.readouterr().err
    assert line in err
    assert err.count("\n") == 1


@pytest.mark.slow
def test_check_says_whether_pictures_suffice(tmp_path, capsys):
    folder = write_photos(tmp_path / "few", photos())
    assert main(["mat", "check", str(folder)]) == 1
    out, err = capsys.readouterr()
    assert out.startswith("mat A4: 6 of 6 pictures can be used\ntoo few: ")
    assert err == ""
    write_photos(folder, [np.full((480, 640), 90, dtype=np.uint8)], first=6)
    more = [photo(MATS[0], pose, seed=k) for k, pose in enumerate(around(13))]
    write_photos(folder, more, first=10)
    assert main(["mat", "check", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[0] == "mat A4: 19 of 20 pictures can be used"
    assert "they suffice" in out
    assert "06.png shows too little of the mat" in err
    assert main(["mat", "check", "--json", str(folder)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["mat"], found["usable"], found["advice"]) == ("A4", 19, [])


def test_check_refuses_what_is_no_folder_or_shows_no_mat(tmp_path, capsys):
    assert main(["mat", "check", str(tmp_path / "none")]) == 2
    assert "is no folder" in capsys.readouterr().err
    assert main(["mat", "check", str(tmp_path)]) == 2
    assert "holds no pictures" in capsys.readouterr().err

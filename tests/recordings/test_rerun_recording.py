"""A collection in Rerun's form, read back by its reader."""

import socket
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.kb.explaining.proof import State
from tests.recordings.collected import Collection, collection

reason = "the extra rerun is not installed: it is too large for everybody who develops"
pytest.importorskip("rerun", reason=reason)
from rerun.chunk import RrdReader  # noqa: E402

from facetlog.recordings.rerun_recording import RerunRecording, rerun_target  # noqa: E402


@pytest.fixture(scope="module")
def collected() -> Collection:
    return collection()


def columns(path: Path) -> dict[str, list[object]]:
    """`entity:component` and its values, in the order of logging."""
    found: dict[str, list[object]] = {}
    for chunk in RrdReader(path).stream().to_chunks():
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            field = f"{str(chunk.entity_path).lstrip('/')}:{name}"
            found.setdefault(field, []).extend(batch.column(name).to_pylist())
    return found


def test_views_corners_faces_and_verdicts_are_in_the_file(
    collected: Collection, tmp_path: Path
) -> None:
    path = tmp_path / "deep" / "views.rrd"
    recording = RerunRecording(str(path), "two views")
    for moment in collected.moments():
        recording.add(moment)
    recording.close()
    found = columns(path)

    def values(entity: str, component: str) -> list[object]:
        ((values),) = [v for k, v in found.items() if k == f"{entity}:{component}"]
        return values

    places = np.array([v[0] for v in values("world/camera", "Transform3D:translation") if v])  # type: ignore[index]
    assert places == pytest.approx(np.array([v.pose.centre for v in collected.taken]), abs=1e-6)
    pictures = [bytes(v[0]) for v in values("world/camera/picture", "EncodedImage:blob") if v]  # type: ignore[index]
    assert pictures == [moment.picture for moment in collected.moments()]
    (corners,) = values("world/corners", "Ellipsoids3D:centers")
    assert np.array(corners) == pytest.approx(collected.scene.points, abs=1e-6)
    (strips,) = values("world/faces", "LineStrips3D:strips")
    assert len(strips) == len(collected.scene.faces)  # type: ignore[arg-type]
    ((*_, candidates),) = [values("world/candidates", "Points3D:positions")]
    assert np.array(candidates)[:, 1] == pytest.approx([1.0, -1.0])
    assert "may turn 0.40 verdicts, in 8 s" in str(values("world/chosen", "Points3D:labels"))
    said = str(values("verdict", "TextDocument:text"))
    assert "is a box" in said
    assert len([v for v in values("world/robot", "Transform3D:translation") if v]) == 61


def test_each_place_of_an_area_has_entities_of_its_own(
    collected: Collection, tmp_path: Path
) -> None:
    path = tmp_path / "area.rrd"
    recording = RerunRecording(str(path), "an area")
    first, second = collected.moments()
    recording.add(replace(first, scene=second.scene, recognition=second.recognition, place=1))
    recording.add(replace(second, place=2))
    recording.close()
    found = columns(path)
    for place in (1, 2):
        assert f"world/place{place}/faces:LineStrips3D:strips" in found
    (*_, said) = found["verdict:TextDocument:text"]
    assert "place 1: t1 is a box" in str(said)
    assert "place 2: t1 is a box" in str(said)


def test_what_has_no_name_is_said_where_it_stands(collected: Collection, tmp_path: Path) -> None:
    path = tmp_path / "nameless.rrd"
    recording = RerunRecording(str(path), "a thing")
    _, moment = collected.moments()
    assert moment.recognition is not None
    fails = tuple(v for v in moment.recognition.verdicts if v.state is State.FAILS)
    recording.add(replace(moment, recognition=replace(moment.recognition, verdicts=fails), place=3))
    recording.close()
    found = columns(path)
    assert "no model matches" in str(found["world/place3/verdicts:Points3D:labels"])
    assert "place 3: no model matches" in str(found["verdict:TextDocument:text"][-1])


def test_a_viewer_that_is_not_there_is_said_at_once() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with pytest.raises(InputError, match="cannot be recorded"):
        RerunRecording(f"rerun+http://127.0.0.1:{port}/proxy", "views")


@pytest.mark.parametrize("given", ["views.bag", "http://localhost:9876", "lively"])
def test_another_target_is_refused(given: str) -> None:
    with pytest.raises(InputError, match=r"give live, a file whose name ends in \.rrd"):
        rerun_target(given)

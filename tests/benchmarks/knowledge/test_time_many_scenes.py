"""A batch comes out the same, however many workers it has and however often it is killed."""

from pathlib import Path

import pytest

from benchmarks.knowledge.time_many_scenes import WANTED_MB, classified, digest, write_scene_list

SCENES = 300


@pytest.fixture
def listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    if not Path("/proc/self/statm").exists():
        pytest.skip("processes are found by /proc")
    return write_scene_list(tmp_path, SCENES)


@pytest.mark.slow
def test_a_run_that_is_killed_five_times_has_the_rows_of_one_that_is_not(
    listed: Path, tmp_path: Path
) -> None:
    found = {}
    for workers, kills in ((1, 0), (2, 0), (1, 5), (2, 5)):
        output = tmp_path / f"{workers}-{kills}.jsonl"
        run = classified(listed, output, workers, SCENES, kills=kills, seed=workers)
        assert len(run.killed) == kills
        assert max(run.worker_mb.values()) <= WANTED_MB
        found[workers, kills] = digest(output)
    assert {count for count, _ in found.values()} == {SCENES}
    assert len(set(found.values())) == 1

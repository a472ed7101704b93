"""Scenes into rows: what a worker process does, with the engine that it keeps."""

import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from facetlog.batch.content import hash_content
from facetlog.batch.memory import compute_share_mb, format_memory_error, get_left_mb
from facetlog.batch.profile import Profile
from facetlog.batch.rows import Row, error_row, make_scene_row
from facetlog.batch.settings import Item, Settings, shape_options
from facetlog.errors import EngineError, FacetlogError
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.brief_verdict import STACKS
from facetlog.kb.limits import Limits
from facetlog.kb.recognize import too_large
from facetlog.perception.facts.all_facts import FactColumns, fact_columns
from facetlog.perception.facts.most_faces import check_face_count
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.read_shape import read_shape
from facetlog.perception.shapes.shape_options import is_scene_file
from facetlog.terminal import fit_on_one_line, make_short_line

BYTES_AT_ONCE = 400_000
"""Of scene files that are read and made into facts together: some 500 faces, and 40 ms."""


@dataclass(slots=True)
class _Read:
    """A scene on its way to a row; `seconds` is what was spent on it alone so far."""

    item: Item
    seconds: float = 0.0
    sha256: str | None = None
    scene: Scene | None = None
    facts: FactColumns | None = None
    error: str = ""


def _blocks(items: Iterable[Item]) -> Iterator[list[Item]]:
    """Yield scene files in blocks that hold little together; what is larger, or a raw shape, alone.

    Whoever takes long, or ends the process, is then the first of its block.
    """
    block: list[Item] = []
    total = 0
    for item in items:
        size = _size(item.place) if is_scene_file(item.place) else BYTES_AT_ONCE
        if block and total + size > BYTES_AT_ONCE:
            yield block
            block, total = [], 0
        block.append(item)
        total += size
    if block:
        yield block


def _size(path: str) -> int:
    try:
        return Path(path).stat().st_size
    except (OSError, ValueError):
        return 0  # reading it says why


class SceneEngine:
    """Scenes into rows by the models of the settings; opened once, for it takes a second."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._memory_mb = settings.memory_mb or compute_share_mb(1)
        self.spent = False
        """Whether memory ran out: whoever has more scenes takes a fresh process for them."""
        self._limits = Limits(seconds=settings.clock_seconds)
        self._judge = BatchJudge(
            tuple(map(Path, settings.models)),
            trusted=settings.trusted,
            crisp=settings.crisp,
            raw=settings.raw,
            limits=self._limits,
        )
        self.models_hash = self._judge.models_hash
        self.models = self._judge.models
        # What the models ask for, and the things that a row counts: no other fact is worked out.
        self._kinds = {name for name, _ in self._judge.needed} | {"thing"}
        self.profile = Profile(self._judge.conditions() if settings.profile else {})
        """Where the time went, of all scenes so far."""

    def row(self, item: Item) -> Row:
        """Return the row of a scene; whatever goes wrong with it is the row's error."""
        (row,) = self.rows((item,))
        return row

    def rows(self, items: Iterable[Item]) -> Iterator[Row]:
        """Yield the rows of scenes, in order; facts of small ones are worked out together.

        So what becomes known of several is counted to the first of them by who watches the time: it
        is a few hundredths of a second.
        """
        for block in _blocks(items):
            scenes = list(map(self._read, block))
            self._add_facts(scenes)
            yield from map(self._row, scenes)

    def _read(self, item: Item) -> _Read:
        """Read the scene of a file."""
        start, read = time.perf_counter(), _Read(item)
        with self.profile.timed("read"), self._told(read):
            read.sha256 = hash_content(Path(item.place))
            scene = read_shape(Path(item.place), shape_options(item, self._settings))
            check_face_count(scene, item.place)
            read.scene = scene
        read.seconds = time.perf_counter() - start
        return read

    def _add_facts(self, scenes: list[_Read]) -> None:
        """Work out the facts of scenes together, and, if one of them is at fault, one by one."""
        known = [(read, read.scene) for read in scenes if read.scene is not None]
        start = time.perf_counter()
        with self.profile.timed("facts"):
            try:
                found = fact_columns([scene for _, scene in known], self._kinds)
            except Exception:  # of one of them: the others go on without it
                for read, scene in known:
                    with self._told(read):
                        (read.facts,) = fact_columns((scene,), self._kinds)
            else:
                for (read, _), facts in zip(known, found, strict=True):
                    read.facts = facts
        for read, _ in known:
            read.seconds += (time.perf_counter() - start) / len(known)

    @contextmanager
    def _told(self, read: _Read) -> Iterator[None]:
        """Record an exception within as the scene's error."""
        item = read.item
        try:
            yield
        except MemoryError:
            self.spent = True
            read.error = make_short_line(f"{item.path}: {format_memory_error(self._memory_mb)}")
        except EngineError as exc:
            # Prolog says the same when it reaches its own limit and when it gets no more memory.
            self.spent = STACKS in str(exc) and get_left_mb() < self._limits.stack_mb
            reason = (
                f"{item.path}: {format_memory_error(self._memory_mb)}" if self.spent else str(exc)
            )
            read.error = make_short_line(reason.replace(item.place, item.path))
        except FacetlogError as exc:
            read.error = make_short_line(str(exc).replace(item.place, item.path))
        except RecursionError:
            read.error = make_short_line(f"{item.path}: it is nested too deeply")
        except Exception as exc:  # a fault of ours: it must not cost the other scenes
            read.error = make_short_line(f"{item.path}: {type(exc).__name__}: {exc}")

    def _row(self, read: _Read) -> Row:
        start = time.perf_counter()
        with self._told(read):
            if read.scene is not None and read.facts is not None:
                return self._judged(read, read.scene, read.facts, start)
        return error_row(
            read.item,
            self._settings,
            read.error,
            models_hash=self.models_hash,
            seconds=read.seconds + time.perf_counter() - start,
            sha256=read.sha256,
        )

    def _judged(self, read: _Read, scene: Scene, facts: FactColumns, start: float) -> Row:
        with self.profile.timed("judge"):
            verdicts = self._judge.judge_columns(facts)
        self.profile.add(verdicts)
        beyond: dict[tuple[str, str], list[str]] = {}
        for verdict in verdicts:
            if verdict.limit:
                beyond.setdefault((verdict.thing, verdict.limit), []).append(verdict.model)
        if (
            any(limit == STACKS for _, limit in beyond) and get_left_mb() < self._limits.stack_mb
        ):  # a fresh process may have more
            raise EngineError(f"{STACKS} was reached")
        too_many = [
            too_large(models, thing, f"{limit} was reached")
            for (thing, limit), models in beyond.items()
        ]
        return make_scene_row(
            read.item,
            self._settings,
            verdicts,
            sha256=read.sha256,
            models_hash=self.models_hash,
            faces=len(scene.faces),
            things=len(facts["thing"][0]) if facts["thing"] else 0,
            seconds=read.seconds + time.perf_counter() - start,
            up=None if scene.up is None else scene.up.tolist(),
            metric=scene.metric,
            warnings=[*map(fit_on_one_line, scene.warnings), *too_many],
        )

    def close(self) -> None:
        """End the engine."""
        self._judge.close()

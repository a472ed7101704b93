"""One scene into one row: what a worker process does, with the engine that it keeps."""

import time
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.batch.content import content_hash
from facetlog.batch.memory import left_mb, needs_more, share_mb
from facetlog.batch.rows import Row, error_row, scene_row
from facetlog.batch.settings import Item, Settings, shape_options
from facetlog.errors import EngineError, FacetlogError
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.limits import Limits
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.facts.most_faces import check_face_count
from facetlog.perception.shapes.read_shape import read_shape
from facetlog.terminal import one_line

if TYPE_CHECKING:
    from facetlog.perception.scene import Scene

__all__ = ["SceneEngine"]

STACKS = "the limit of memory (Prolog's stacks)"
"""How bridge.pl begins what it says when a stack cannot grow."""


class SceneEngine:
    """Scenes into rows by the models of the settings; opened once, for it takes a second."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._memory_mb = settings.memory_mb or share_mb(1)
        self.spent = False
        """Whether memory ran out: whoever has more scenes takes a fresh process for them."""
        self._limits = Limits(seconds=settings.seconds)
        self._judge = BatchJudge(
            tuple(map(Path, settings.models)),
            trusted=settings.trusted,
            crisp=settings.crisp,
            limits=self._limits,
        )
        self.models_hash = self._judge.models_hash
        self.models = self._judge.models
        # What the models ask for, and the things that a row counts: no other fact is worked out.
        self._kinds = {name for name, _ in self._judge.asked} | {"thing"}

    def row(self, item: Item) -> Row:
        """The row of a scene; whatever goes wrong with it is the row's error."""
        start = time.perf_counter()
        sha256 = None
        try:
            sha256 = content_hash(Path(item.place))
            return self._judged(item, sha256, start)
        except MemoryError:
            self.spent = True
            error = one_line(f"{item.path}: {needs_more(self._memory_mb)}")
        except EngineError as exc:
            # Prolog says the same when it reaches its own limit and when it gets no more memory.
            self.spent = STACKS in str(exc) and left_mb() < self._limits.stack_mb
            reason = f"{item.path}: {needs_more(self._memory_mb)}" if self.spent else str(exc)
            error = one_line(reason.replace(item.place, item.path))
        except FacetlogError as exc:
            error = one_line(str(exc).replace(item.place, item.path))
        except RecursionError:
            error = one_line(f"{item.path}: it is nested too deeply")
        except Exception as exc:  # a fault of ours: it must not cost the other scenes
            error = one_line(f"{item.path}: {type(exc).__name__}: {exc}")
        return error_row(
            item,
            self._settings,
            error,
            models_hash=self.models_hash,
            seconds=time.perf_counter() - start,
            sha256=sha256,
        )

    def _judged(self, item: Item, sha256: str, start: float) -> Row:
        scene: Scene = read_shape(Path(item.place), shape_options(item, self._settings))
        check_face_count(scene, item.place)
        facts = fact_rows(scene, self._kinds)
        verdicts = self._judge.judge(facts)
        return scene_row(
            item,
            self._settings,
            verdicts,
            sha256=sha256,
            models_hash=self.models_hash,
            faces=len(scene.faces),
            things=len(facts["thing"]),
            seconds=time.perf_counter() - start,
            up=None if scene.up is None else scene.up.tolist(),
            metric=scene.metric,
            warnings=tuple(map(one_line, scene.warnings)),
        )

    def close(self) -> None:
        """Ends the engine."""
        self._judge.close()

"""Scenes into rows: what a worker process does, with the engine that it keeps."""

import time
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.batch.memory import compute_share_mb, format_memory_error, get_left_mb
from facetlog.batch.profile import Profile
from facetlog.batch.rows import Row, error_row, make_scene_row
from facetlog.batch.settings import Item, Settings, open_scene
from facetlog.errors import EngineError, FacetlogError
from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.brief_verdict import STACKS
from facetlog.kb.limits import Limits
from facetlog.kb.recognize import too_large
from facetlog.perception.facts.pieces.kinds import PIECE_KINDS
from facetlog.terminal import fit_on_one_line, make_short_line

if TYPE_CHECKING:
    from facetlog.kept_scenes import Summary
    from facetlog.perception.facts.named_rows import FactColumns


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
        self._solid_parts = any(kind.functor in self._kinds for kind in PIECE_KINDS)
        self.profile = Profile(self._judge.conditions() if settings.profile else {})
        """Where the time went, of all scenes so far."""

    def row(self, item: Item) -> Row:
        """Return the row of a scene; whatever goes wrong with it is the row's error."""
        start = time.perf_counter()
        sha256 = None
        try:
            with self.profile.timed("read"):
                kept = open_scene(item, self._settings, solid_parts=self._solid_parts)
                sha256 = kept.sha256
                if not kept.has_facts(self._kinds):
                    kept.scene()
            with self.profile.timed("facts"):
                facts = kept.facts(self._kinds)
            return self._judge_scene(item, kept.summary, facts, sha256, start)
        except Exception as exc:
            error = self._describe_error(item, exc)
        return error_row(
            item,
            self._settings,
            error,
            models_hash=self.models_hash,
            seconds=time.perf_counter() - start,
            sha256=sha256,
        )

    def _describe_error(self, item: Item, exc: Exception) -> str:
        """Return what a row says of an exception, and note whether memory ran out."""
        # Prolog says the same when it reaches its own limit and when it gets no more memory.
        if isinstance(exc, MemoryError) or (
            isinstance(exc, EngineError)
            and STACKS in str(exc)
            and get_left_mb() < self._limits.stack_mb
        ):
            self.spent = True
            text = f"{item.path}: {format_memory_error(self._memory_mb)}"
        elif isinstance(exc, FacetlogError):
            text = str(exc).replace(item.place, item.path)
        elif isinstance(exc, RecursionError):
            text = f"{item.path}: it is nested too deeply"
        else:  # a fault of ours: it must not cost the other scenes
            text = f"{item.path}: {type(exc).__name__}: {exc}"
        return make_short_line(text)

    def _judge_scene(
        self, item: Item, scene: "Summary", facts: "FactColumns", sha256: str, start: float
    ) -> Row:
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
            item,
            self._settings,
            verdicts,
            sha256=sha256,
            models_hash=self.models_hash,
            faces=scene.faces,
            things=len(facts["thing"][0]) if facts["thing"] else 0,
            seconds=time.perf_counter() - start,
            up=scene.up,
            metric=scene.metric,
            warnings=[*map(fit_on_one_line, scene.warnings), *too_many],
        )

    def close(self) -> None:
        """End the engine."""
        self._judge.close()

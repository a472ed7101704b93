"""The page of one scene: all verdicts with their proofs, and the scene in 3-D."""

from typing import TypedDict

from facetlog.batch.loaded_scene import SCENE, loaded_scene
from facetlog.batch.memory import compute_share_mb, format_memory_error
from facetlog.batch.settings import Item, Settings, open_scene
from facetlog.errors import FacetlogError, InputError
from facetlog.kb.recognize import judge_loaded_scene
from facetlog.page.contents import Subject
from facetlog.page.write import page
from facetlog.perception.facts.pieces.piece_facts import shown_pieces
from facetlog.terminal import make_short_line


class ScenePage(TypedDict):
    """A page as text, or why there is none."""

    page: str | None
    error: str | None


def scene_page(item: Item, settings: Settings, sha256: str) -> ScenePage:
    """Return the page of a scene whose content is that of its row, by the SHA-256 that the
    row has.
    """
    try:
        return {"page": _page(item, settings, sha256), "error": None}
    except MemoryError:
        error = format_memory_error(settings.memory_mb or compute_share_mb(1))
    except FacetlogError as exc:
        error = str(exc).replace(item.place, item.path).removeprefix(f"{item.path}: ")
    except Exception as exc:  # a fault of ours: it must not cost the other scenes
        error = f"{type(exc).__name__}: {exc}"
    return {"page": None, "error": make_short_line(error)}


def _page(item: Item, settings: Settings, sha256: str) -> str:
    kept = open_scene(item, settings)
    if kept.sha256 != sha256:
        raise InputError("it was changed since it was classified")
    scene = kept.scene()
    with loaded_scene(scene, settings) as base:
        found = judge_loaded_scene(base, SCENE, near=True)
    others = tuple(verdict for verdict in found.verdicts if verdict not in found.best)
    pieces = shown_pieces(scene)
    return page(Subject(scene, pieces, found.best, others, warnings=scene.warnings))

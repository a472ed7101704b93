"""Scene files: which of the arguments they are, what they are called, and their facts.

Meshes and clouds are scenes as well, with up and unit as they are stated, or known without that.
"""

import json
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.errors import InputError
from facetlog.kb.loading.encode import Fact
from facetlog.pictures_hint import make_pictures_hint
from facetlog.plain_text import plain_text
from facetlog.safe_read import MOST_SCENE_BYTES, read_regular
from facetlog.terminal import warn

if TYPE_CHECKING:
    from facetlog.kept_scenes import KeptScene
    from facetlog.perception.shapes.shape_options import ShapeOptions

SCENE_FILE = "scene.json"  # in a folder written by -o
SUFFIX = ".json"


@dataclass(frozen=True, slots=True)
class SceneFile:
    """A file of a scene, mesh or cloud: `name` is what the knowledge base calls the scene, which is
    read when it is asked for. What is asked for raises InputError for a file that holds none.
    """

    path: Path
    name: str
    kept: "KeptScene"

    @property
    def warnings(self) -> tuple[str, ...]:
        """Doubts about a mesh or cloud, a line each."""
        return self.kept.summary.warnings if is_raw_shape(self.path) else ()

    def facts(self) -> Iterator[Fact]:
        """Yield the scene's facts, which are computed when the first is requested."""
        from facetlog.perception.facts.all_facts import fact_rows

        rows = fact_rows(self.kept.scene())
        for functor in tuple(rows):  # in the order of scene_facts
            found = rows.pop(functor)
            # Handed over is let go: of many faces the rest needs the room.
            found.reverse()
            while found:
                yield (functor, *found.pop())

    def facts_on_demand(self) -> Iterator[Fact]:
        """Yield the facts that `facts` leaves out."""
        for fact in self.kept.facts_on_demand():
            yield fact.row


def scene_file(path: Path, options: "ShapeOptions | None" = None) -> SceneFile:
    """Find the scene file at a path or in the folder there, under its own name; or a mesh or a
    cloud, with the up, unit and sensor that `options` state.

    Raise InputError if there is none. What it holds is checked when its facts are asked for.
    """
    from facetlog.kept_scenes import (
        SceneKeeper,
    )  # loaded only now: a shell without scenes does without
    from facetlog.perception.shapes.shape_options import ShapeOptions

    inside = path / SCENE_FILE if path.is_dir() else path
    given = options or ShapeOptions(find_floor=True)
    if is_raw_shape(path):
        name = plain_text(path.stem or path.resolve().name)
        return SceneFile(path, name, SceneKeeper().open(path, given))
    if path.suffix not in ("", SUFFIX) and (hint := make_pictures_hint(path)):
        raise InputError(f"{path} holds no scene{hint}")
    try:
        data = read_regular(inside, MOST_SCENE_BYTES)
    except FileNotFoundError:
        if inside is path:
            raise InputError(f"{path} does not exist: give a scene.json or its folder") from None
        raise InputError(
            f"{path} holds no {SCENE_FILE}: give a folder that -o wrote, or a scene file"
            f"{make_pictures_hint(path)}"
        ) from None
    except OSError as exc:
        raise InputError(f"{inside} cannot be read: {exc.strerror or exc}") from exc
    if options is not None and options.sensor is not None:
        warn(f"{path}: a scene says from where it was seen itself; --sensor does not count")
    name = plain_text(_read_name(data) or inside.stem)
    return SceneFile(inside, name, SceneKeeper().open(inside, given, data))


def is_raw_shape(path: Path) -> bool:
    """Return whether there is a mesh or a cloud, by the suffix, or the folder of a COLMAP model."""
    if path.suffix == SUFFIX or not _does_exist(str(path)):
        return False
    # Loaded only now: scenes do without.
    if path.is_dir():
        from facetlog.perception.reading.shape_files.clouds.colmap_model import find_colmap_model

        return not (path / SCENE_FILE).exists() and find_colmap_model(path) is not None
    from facetlog.perception.shapes.shape_options import SUFFIXES, is_scene_file

    return path.suffix.lower() in SUFFIXES and not is_scene_file(path.name)


def _read_name(data: bytes) -> str | None:
    try:
        record = json.loads(data)
    except (ValueError, RecursionError):
        return None  # not a scene: its facts will say why
    name = record.get("name") if isinstance(record, dict) else None
    return name if isinstance(name, str) and name else None


def make_names_distinct(
    files: Sequence[SceneFile], taken: Collection[str] = ()
) -> tuple[SceneFile, ...]:
    """Return the files with distinct names, told apart by folder or file.

    For example `block-0@second`, and where that is taken, `block-0@runs/second`.
    """
    names = [file.name for file in files]
    used = set(taken)
    found = []
    for file in files:
        name = file.name
        if names.count(name) > 1 or name in used:
            name = next(n for n in _iter_names(file) if n not in used)
        used.add(name)
        found.append(replace(file, name=name))
    return tuple(found)


def _iter_names(file: SceneFile) -> Iterator[str]:
    place = file.path.resolve()
    about = place.parent if place.name == SCENE_FILE else place.with_suffix("")
    folders = about.parts[1:]
    for length in range(1, len(folders) + 1):
        yield f"{file.name}@{'/'.join(folders[-length:])}"
    yield from (f"{file.name}#{number}" for number in count(2))


def split_scenes_and_goal(arguments: Sequence[str]) -> tuple[tuple[Path, ...], str | None]:
    """Split arguments into the scenes and the goal, which is the last unless a file is called so.

    Raise InputError if there is no scene, or if the goal looks like a file that is not there.
    """
    last = arguments[-1]
    if last.strip() and (_does_exist(last) or _looks_like_path(last)):
        paths, goal = arguments, None
    else:
        paths, goal = arguments[:-1], last
    if not paths:
        raise InputError(f"{last!r} is no file: give a scene.json or its folder before the goal")
    for path in paths:
        if not (path.strip() and _does_exist(path)):
            raise InputError(f"{path} does not exist: give a scene.json or its folder")
    return tuple(map(Path, paths)), goal


def _does_exist(argument: str) -> bool:
    try:
        return Path(argument).exists()
    except (OSError, ValueError):  # too long for a file's name, or with a NUL: a goal
        return False


def _looks_like_path(argument: str) -> bool:
    """Return whether an argument is no goal but a file's name.

    >>> [_looks_like_path(a) for a in ("out/a", "a.json", "X is 6/3", "face(F)", "true")]
    [True, True, False, False, False]
    """
    if "(" in argument or any(c.isspace() for c in argument):
        return False
    return argument.endswith(SUFFIX) or "/" in argument

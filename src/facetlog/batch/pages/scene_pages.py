"""A page for each scene of a run, in a folder with a list of them."""

import json
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePath
from urllib.parse import quote

from facetlog.batch.pages.render import render_page
from facetlog.batch.pool import Task
from facetlog.batch.rows import Row, read_confidence
from facetlog.batch.run import Finished, Progress, Workers
from facetlog.errors import InputError
from facetlog.output_folder import check_replaceable, output_folder
from facetlog.plurals import many
from facetlog.query_shell.scene_files import SCENE_FILE
from facetlog.terminal import printable

OPTION = "--html"
INDEX = "index.html"

MOST_PAGES = 5_000
"""Of a run: a page takes about a megabyte, and a second to make."""

NAME_BYTES = 200
"""Of a page's name, which with its number and suffix must be below 255."""


def check_pages(
    folder: Path, scenes: int, inputs: Iterable[Path], others: Iterable[Path | None]
) -> None:
    """Raise InputError if pages of so many scenes could not be written there: before the run.

    `inputs` are the files that the run reads, `others` those that it writes as well: the folder is
    to hold the pages alone.
    """
    if scenes > MOST_PAGES:
        raise InputError(
            f"{OPTION} {folder}: {scenes:,} scenes would be as many pages of a megabyte each: "
            f"give at most {MOST_PAGES:,} scenes, or leave it out"
        )
    check_replaceable(folder, OPTION, inputs)
    for file in others:
        if file is not None and folder.resolve() in file.resolve().parents:
            raise InputError(f"{OPTION} {folder}: holds pages alone: write {file} elsewhere")


def write_pages(
    folder: Path, done: Finished, workers: Workers, progress: Progress | None = None
) -> dict[str, str]:
    """Write the pages and their list, all or none; those that cannot be made, by path, with why.

    `workers` make them, of each scene without an error; one at a time is in memory here.
    """
    paths = [item.path for item in done.items]
    names = dict(zip(paths, iter_page_names(paths), strict=True))
    tasks = [
        Task(item, page=row["sha256"])
        for item, row in zip(done.items, done.rows(), strict=True)
        if row["error"] is None
    ]
    missing: dict[str, str] = {}
    with output_folder(folder, {"command": "classify"}, OPTION) as made:
        for count, answer in enumerate(workers.answers(tasks), start=1):
            path, found = answer.task.item.path, json.loads(answer.line)
            if found["error"] is not None:
                missing[path] = found["error"].removeprefix(f"{path}: ")
            else:
                text = found["page"].encode("utf-8", "backslashreplace")
                (made / names[path]).write_bytes(text)
            if progress is not None:
                progress(count, len(tasks), len(missing))
        pieces = render_page(
            "scene_pages.html.jinja",
            title=many(len(done.items), "scene"),
            rows=(_entry(row, names, missing) for row in done.rows()),
        )
        with (made / INDEX).open("wb") as file:
            file.writelines(pieces)
    return missing


def iter_page_names(paths: Iterable[str]) -> Iterator[str]:
    """Yield a file's name for the page of each scene, all different on any system.

    >>> scenes = ["a/box.glb", "b/Box.ply", "runs/7/scene.json", "in?:/ü *.obj", "index"]
    >>> list(iter_page_names(scenes))
    ['box.html', 'Box-2.html', '7.html', 'ü_.html', 'index-2.html']
    """
    # Some systems take names as the same that differ in case, or in how an accent is written.
    taken = {PurePath(INDEX).stem}
    counts: Counter[str] = Counter()
    for path in paths:
        name = _plain(path)
        key, unique = name.casefold(), name
        while unique.casefold() in taken:
            counts[key] += 1
            unique = f"{name}-{counts[key] + 1}"
        taken.add(unique.casefold())
        yield f"{unique}.html"


def _plain(path: str) -> str:
    """Return the scene's name without what a shell, an address or a file system takes for
    something.
    """
    place = PurePath(path)
    # What -o writes is known by its folder.
    name = (place.name == SCENE_FILE and place.parent.name) or place.stem
    safe = re.sub(r"[^\w.-]+", "_", unicodedata.normalize("NFC", name)).lstrip(".-")
    return safe.encode()[:NAME_BYTES].decode(errors="ignore") or "scene"


def _entry(row: Row, names: dict[str, str], missing: dict[str, str]) -> dict[str, str]:
    path = row["path"]
    why_not = row["error"] or missing.get(path, "")
    held = row["model"] is not None
    return {
        "path": printable(path),
        "page": "" if why_not else quote(names[path]),
        "answer": "" if row["error"] else row["model"] or "none",
        "sure": read_confidence(row).format(row["degree"]) if held else "",
        "why_not": printable(why_not.removeprefix(f"{path}: ")),
    }

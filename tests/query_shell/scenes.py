"""Scene files for tests."""

import dataclasses
from pathlib import Path

from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_file import write_scene


def write_block(folder: Path, name: str = "block", *, metric: bool = True) -> Path:
    """A block of 0.3 m by 0.2 m by 0.1 m in a folder as -o writes it."""
    folder.mkdir(parents=True, exist_ok=True)
    block = cuboid(0.3, 0.2, 0.1)
    write_scene(dataclasses.replace(block, name=name, metric=metric), folder / "scene.json")
    return folder

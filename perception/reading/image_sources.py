"""The pictures in a folder: files, and frames of videos spread evenly over each."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.reading.exif import read_quarter_turns
from facetlog.perception.reading.picture_file import PICTURE_SUFFIXES, read_picture, turned
from facetlog.perception.reading.skipped_images import LeftOut
from facetlog.perception.reading.video_file import (
    COUNTED,
    VideoFrame,
    VideoFrames,
    read_frame_count,
)
from facetlog.perception.types import Image

FRAMES = 30
"""Number of frames used of a video: on a walk round a thing, one every 12 degrees or so."""


@dataclass(frozen=True, slots=True)
class Shot:
    """A picture: its file, and which frame where that is a video; by how many quarter turns to the
    right it is read."""

    path: Path
    frame: VideoFrame | None = None
    turns: int = 0

    @property
    def name(self) -> str:
        """Name for messages and views."""
        return self.path.name if self.frame is None else self.frame.name(0)

    @property
    def place(self) -> str:
        """File, or frame of a video, for messages."""
        return str(self.path if self.frame is None else self.frame)

    def read(self, videos: VideoFrames) -> Image:
        """Return the picture, grey, (H, W); InputError if it cannot be had."""
        image = read_picture(self.path) if self.frame is None else videos.read(self.frame)
        return turned(image, self.turns)

    def unreadable(self, fault: InputError) -> LeftOut:
        """Return the picture as left out for a fault, whose message may name it or not."""
        line = str(fault) if self.place in str(fault) else f"picture {self.place}: {fault}"
        return LeftOut(self.name, line, self.place)

    @property
    def upright(self) -> "Shot":
        """The picture turned as its EXIF says that it is shown."""
        return (
            self if self.frame is not None else replace(self, turns=read_quarter_turns(self.path))
        )


def has_shots(folder: Path) -> bool:
    """Return whether there is a picture or a video in a folder, by the endings of names."""
    return any(True for _ in _files(folder))


def list_shots(folder: Path) -> tuple[Shot, ...]:
    """Return all pictures of a folder, in the order of their names; InputError for a video that
    cannot be read.
    """
    shots: list[Shot] = []
    for path in _files(folder):
        if path.suffix.lower() in PICTURE_SUFFIXES:
            shots.append(Shot(path))
            continue
        count = read_frame_count(str(path))
        if count == 0:
            raise InputError(f"{path} does not say how many frames it has: take them out of it")
        numbers = np.unique(np.linspace(0, count - 1, min(FRAMES, count)).round().astype(int))
        shots += [Shot(path, VideoFrame(str(path), int(n))) for n in numbers]
    return tuple(shots)


def _files(folder: Path) -> list[Path]:
    kinds = (*PICTURE_SUFFIXES, *COUNTED)
    found = (p for p in folder.iterdir() if p.suffix.lower() in kinds)
    return sorted(p for p in found if not p.name.startswith("."))

"""What a poses file may name unless it is trusted: pictures and videos in its own folder.

A poses file may be a stranger's. What it names is opened, its size and whether it is a picture are
said, and a camera's address would be dialled.
"""

from pathlib import Path

from facetlog.errors import InputError
from facetlog.perception.reading.poses_file import PosedPicture

__all__ = ["OutsideError", "check_own_folder"]

WAY_OUT = "put it into that folder, or give --trust if the poses file is your own"


class OutsideError(InputError):
    """A poses file names what is not in its folder: absolute, by "..", or by a link."""


def check_own_folder(picture: PosedPicture, source: Path) -> None:
    """Nothing; raises OutsideError if the picture is not in the folder of the poses file `source`,
    where its path leads in the end, or is a camera's.

    What is not there is taken by its name: whoever opens it says that it is missing.
    """
    frame = picture.frame
    if frame is not None and frame.number is None:
        raise OutsideError(
            f"{source}: camera {frame.source} is opened only if the poses file is your own: "
            "give --trust"
        )
    path = picture.path if frame is None else Path(frame.source)
    what = f"picture {picture.name!r}" if frame is None else f"video {frame.source!r}"
    folder = source.parent
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):  # a loop of links, or no name of a file
        return
    if not inside:
        raise OutsideError(f"{source}: {what} is outside of {folder.resolve()}: {WAY_OUT}")

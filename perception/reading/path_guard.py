"""Path check of untrusted poses files and models: they may name only files in their own folder.

They may come from a stranger. The files that they name are opened, messages reveal their size and
what they are, and a camera's address would be connected to.
"""

from collections.abc import Sequence
from pathlib import Path

from facetlog.errors import InputError
from facetlog.perception.reading.pose_files.poses_file import PosedPicture

WAY_OUT = "put it into that folder, or trust the {} (--trust, trust=True) if it is your own"


class OutsideError(InputError):
    """A file names what is not in its folder: absolute, by "..", or by a link."""


def check_own_folder(picture: PosedPicture, folder: Path, source: Path) -> None:
    """Raise OutsideError if the picture, its links resolved, is outside of the `folder` of the
    poses file `source`, or is a camera's.

    A missing file is checked by its name: the reader reports that it is missing.
    """
    frame = picture.frame
    if frame is not None and frame.number is None:
        raise OutsideError(
            f"{source}: camera {frame.source} is opened only if the poses file is your own: "
            "trust it (--trust, trust=True)"
        )
    path = picture.path if frame is None else Path(frame.source)
    what = f"picture {picture.name!r}" if frame is None else f"video {frame.source!r}"
    check_inside(path, (folder,), source, what)


def check_inside(
    path: Path, folders: Sequence[Path], source: Path, what: str, kind: str = "poses file"
) -> None:
    """Raise OutsideError if a path that `source` names is, its links resolved, outside of all
    folders.
    """
    try:
        found = path.resolve()
        inside = any(found.is_relative_to(folder.resolve()) for folder in folders)
    except (OSError, RuntimeError, ValueError):  # a loop of links, or no name of a file
        return
    if not inside:
        raise OutsideError(
            f"{source}: {what} is outside of {folders[0].resolve()}: {WAY_OUT.format(kind)}"
        )

"""Views of a folder that is being written: each once its pose is there and its picture complete.

The poses file and pictures may be written in any order and in pieces: what cannot be read yet is
tried again until nothing new came before a time-out.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from time import monotonic, sleep

from facetlog.errors import InputError
from facetlog.perception.reading.path_guard import check_own_folder
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions
from facetlog.perception.reading.pose_files.poses_file import PosesFile
from facetlog.perception.reading.pose_files.register import find_poses_path, read_poses
from facetlog.perception.reading.skipped_images import LeftOut
from facetlog.perception.reading.video_file import VideoFrame
from facetlog.perception.reading.view_image import ViewLoader
from facetlog.perception.types import FloatArray, PoseErrorKind, View

# Interval at which the folder is checked, s.
POLL_S = 0.1


class FollowedViews:
    """The views of a folder or poses file (read_views.py), in the order in which they come.

    Iteration is lazy: no picture is read before the next view is requested. It ends when no new
    view came for `timeout` seconds; `ended` is then the reason. `problems` lists the frames without
    a pose and the pictures that could not be read so far, at the end also an unreadable poses file.
    `up`, `metric` and `error_kind` are those of the poses file, from the first view on. InputError
    if nothing could be read at all, OutsideError for a picture outside of the folder unless the
    file is `trusted` (path_guard.py).
    """

    def __init__(
        self,
        path: Path,
        *,
        unit: str | None = None,
        trusted: bool = False,
        timeout: float,
        clock: Callable[[], float] = monotonic,
        wait: Callable[[float], None] = sleep,
    ) -> None:
        self.path, self.name = path, (path if path.is_dir() else path.parent).resolve().name
        self.up: FloatArray | None = None
        self.metric = False
        self.error_kind = PoseErrorKind.ODOMETRY
        self.ended = ""
        self._trusted, self._source = trusted, path
        self._options = PoseOptions(unit)
        self._timeout, self._clock, self._wait = timeout, clock, wait
        self._file: PosesFile | None = None
        self._stamp: tuple[int, int] | None = None
        self._fault: InputError | None = None
        self._taken: set[tuple[Path, VideoFrame | None, str]] = set()
        self._waiting: dict[str, str] = {}
        self._loader = ViewLoader()

    def __iter__(self) -> Iterator[View]:
        last = self._clock()
        while True:
            self._read_poses()
            self._waiting = {}
            file = self._file
            for picture in file.pictures if file else ():
                key = picture.path, picture.frame, picture.name
                if key in self._taken:
                    continue
                # Only now: what is there may become a link until it is read.
                if file and not self._trusted:
                    check_own_folder(picture, file.folder, self._source)
                try:
                    found = self._loader.load(picture)
                except InputError as exc:
                    self._waiting[picture.name] = str(exc)
                    continue
                if isinstance(found, LeftOut):
                    self._waiting[picture.name] = found.line
                    continue
                self._taken.add(key)
                yield found
                last = self._clock()
            if self._clock() - last >= self._timeout:
                break
            self._wait(POLL_S)
        if self._fault is not None and self._file is None:
            raise self._fault
        self.ended = f"no new view came for {self._timeout:g} s"

    @property
    def problems(self) -> tuple[str, ...]:
        """One line for each problem; frames with the same problem share a line."""
        broken = () if self._fault is None or not self.ended else (str(self._fault),)
        lines = [*map(str, self._file.faults if self._file else ()), *self._waiting.values()]
        return (*broken, *dict.fromkeys(f"{line}; left out" for line in lines))

    def _read_poses(self) -> None:
        # Keeps the previous contents while the file is being rewritten.
        try:
            source = self._source = find_poses_path(self.path)
            if source.is_dir():
                raise InputError(
                    f"{self.path} has no file of poses yet; of pictures alone all are needed at "
                    "once: leave out --follow"
                )
            about = source.stat()
            stamp = (about.st_mtime_ns, about.st_size)
            if stamp == self._stamp and self._fault is None:
                return
            self._file, self._stamp, self._fault = read_poses(source, self._options), stamp, None
            self.up, self.metric = self._file.up, self._file.metric
            self.error_kind = self._file.error_kind
        except InputError as exc:
            self._fault = exc
        except OSError as exc:  # gone between being found and being read
            self._fault = InputError(f"{self.path} cannot be read: {exc}")

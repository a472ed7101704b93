"""COLMAP's structure from motion, as a program of its own: sfm_poses.py starts it and reads on.

The request is a file that is named to it, progress and the outcome go out by standard output, as
lines of JSON. What is wrong inside COLMAP ends a process, its calls cannot be interrupted, and its
libraries go with OpenCV's only if they are loaded after them: nothing of that may happen to a
program that merely uses this one.
"""

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path

# In this order: see above.
import cv2  # noqa: F401
import pycolmap
from pydantic import TypeAdapter

from facetlog.errors import InputError
from facetlog.perception.reading.exif import USUAL_FOCAL, TakenWith, taken_with
from facetlog.perception.reading.image_sources import Shot
from facetlog.perception.reading.sfm.outcome import LEAST_PICTURES, Outcome, Pair, Request, Settings
from facetlog.perception.reading.skipped_images import LeftOut
from facetlog.perception.reading.video_file import VideoFrames

Report = Callable[[str, int, int], None]


class _Cameras:
    """A camera for all pictures of one size and zoom."""

    def __init__(self, database: pycolmap.Database, model: str) -> None:
        self._database, self._model = database, model
        self._known: dict[tuple[int, int, TakenWith], tuple[int, int]] = {}

    def of(self, shot: Shot, width: int, height: int) -> tuple[int, int]:
        """Return the numbers of a picture's camera, and of the rig that COLMAP wants round it."""
        lens = taken_with(shot.path) if shot.frame is None else TakenWith(str(shot.path))
        kind = width, height, lens
        if kind not in self._known:
            focal = lens.compute_focal_px(width, height)
            diagonal = float((width**2 + height**2) ** 0.5)
            camera = pycolmap.Camera.create_from_model_name(
                0, self._model, focal or USUAL_FOCAL * diagonal, width, height
            )
            camera.has_prior_focal_length = focal is not None
            number = self._database.write_camera(camera)
            rig = pycolmap.Rig()
            rig.add_ref_sensor(pycolmap.sensor_t(pycolmap.SensorType.CAMERA, number))
            self._known[kind] = number, self._database.write_rig(rig)
        return self._known[kind]


def mapped(request: Request, report: Report) -> Outcome:
    """Place the pictures, and write the largest group as a COLMAP model."""
    pycolmap.logging.minloglevel = int(pycolmap.logging.FATAL)
    pycolmap.set_random_seed(request.settings.seed)
    path = request.work / "database.db"
    database = pycolmap.Database.open(path)
    features, unreadable = _extract_features(request.shots, request.settings, database, report)
    database.close()
    names = [shot.name for shot in request.shots]
    if len(features) < LEAST_PICTURES:
        return Outcome(features, unreadable)
    numbers = [number for number, name in enumerate(names) if name in features]
    _match(path, numbers, request, report)
    pairs = _pairs(path, names)
    groups = _placed(path, len(numbers), request, report)
    if not groups:
        return Outcome(features, unreadable, pairs)
    placed = tuple(_names_in(group, names) for group in groups)
    largest = groups[0]
    for image in largest.images.values():
        image.name = names[int(image.name)]
    largest.write(request.model)
    return Outcome(
        features,
        unreadable,
        pairs,
        placed,
        largest.compute_mean_reprojection_error(),
    )


def _extract_features(
    shots: tuple[Shot, ...], settings: Settings, database: pycolmap.Database, report: Report
) -> tuple[dict[str, int], tuple[LeftOut, ...]]:
    """Return the number of features of each picture, which are then in the database under its
    number: names may have spaces, which lists of pairs have not.
    """
    options = pycolmap.FeatureExtractionOptions()
    options.use_gpu, options.num_threads = False, 1
    options.max_image_size = settings.longest_side_px
    options.sift.max_num_features = settings.most_features
    extractor = pycolmap.FeatureExtractor.create(options, pycolmap.Device.cpu)
    cameras, videos = _Cameras(database, settings.camera), VideoFrames()
    features: dict[str, int] = {}
    unreadable: list[LeftOut] = []
    for number, shot in enumerate(shots):
        try:
            image = shot.read(videos)
        except InputError as exc:
            unreadable.append(shot.unreadable(exc))
            continue
        height, width = image.shape
        camera, rig = cameras.of(shot, width, height)
        points, descriptors = extractor.extract(pycolmap.Bitmap.from_array(image))
        picture = database.write_image(pycolmap.Image(name=f"{number}", camera_id=camera))
        frame = pycolmap.Frame()
        frame.rig_id = rig
        sensor = pycolmap.sensor_t(pycolmap.SensorType.CAMERA, camera)
        frame.add_data_id(pycolmap.data_t(sensor, picture))
        database.write_frame(frame)
        database.write_keypoints(picture, pycolmap.keypoints_to_matrix(points))
        database.write_descriptors(picture, descriptors)
        features[shot.name] = len(points)
        report("find features", number + 1, len(shots))
    videos.close()
    return features, tuple(unreadable)


def _match(path: Path, numbers: list[int], request: Request, report: Report) -> None:
    """Match all pairs, those of one picture with the ones before it at a time."""
    matching = pycolmap.FeatureMatchingOptions()
    matching.use_gpu, matching.num_threads = False, request.threads
    verification = pycolmap.TwoViewGeometryOptions()
    verification.ransac.random_seed = request.settings.seed
    pairing = pycolmap.ImportedPairingOptions()
    pairing.match_list_path = request.work / "pairs.txt"
    for k, number in enumerate(numbers[1:], start=1):
        lines = (f"{before} {number}\n" for before in numbers[:k])
        pairing.match_list_path.write_text("".join(lines), encoding="utf-8")
        pycolmap.match_image_pairs(path, matching, pairing, verification, pycolmap.Device.cpu)
        # A picture takes the longer, the more are before it.
        report("match pictures", k * (k + 1) // 2, len(numbers) * (len(numbers) - 1) // 2)


def _pairs(path: Path, names: list[str]) -> tuple[Pair, ...]:
    database = pycolmap.Database.open(path)
    name_of = {image.image_id: names[int(image.name)] for image in database.read_all_images()}
    found = []
    for pair, geometry in zip(*database.read_two_view_geometries(), strict=True):
        one, other = pycolmap.pair_id_to_image_pair(pair)
        points = len(geometry.inlier_matches)
        if points:
            found.append(Pair(name_of[one], name_of[other], points))
    database.close()
    return tuple(found)


def _placed(
    path: Path, count: int, request: Request, report: Report
) -> list[pycolmap.Reconstruction]:
    """Return the groups of pictures that were placed together, the largest first."""
    options = pycolmap.IncrementalPipelineOptions()
    # On one thread: several add up in any order, and their rounding decides what is an outlier.
    options.random_seed, options.num_threads = request.settings.seed, 1
    options.min_model_size, options.extract_colors = LEAST_PICTURES, False
    models = request.work / "models"
    models.mkdir()
    placed = 2  # what it begins with

    def another() -> None:
        nonlocal placed
        placed = min(placed + 1, count)
        report("place pictures", placed, count)

    found = pycolmap.incremental_mapping(
        path, request.work, models, options, next_image_callback=another
    )
    groups = list(found.values())
    return sorted(groups, key=lambda r: (r.num_reg_images(), r.num_points3D()), reverse=True)


def _names_in(group: pycolmap.Reconstruction, names: list[str]) -> tuple[str, ...]:
    return tuple(sorted(names[int(group.image(k).name)] for k in group.reg_image_ids()))


def main() -> None:
    """Answer the request in the file that is named."""
    request = TypeAdapter(Request).validate_json(Path(sys.argv[1]).read_bytes())
    # What COLMAP prints is no part of the answer.
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)

    def report(step: str, done: int, total: int) -> None:
        print(json.dumps({"progress": [step, done, total]}), file=out, flush=True)

    outcome = mapped(request, report)
    answer = TypeAdapter(Outcome).dump_python(outcome, mode="json")
    print(json.dumps({"outcome": answer}), file=out, flush=True)


if __name__ == "__main__":
    main()

"""A scene that views come to one at a time.

Two loops, as in visual SLAM (Klein and Murray 2007): each view updates by the recursion what is
known, in time that does not grow; and when the kept views have become a third more
or other, faces are searched anew in them, which takes as long as it does for so many views.

A view updates corners, and loose edges, which bound no face: each is a line in space, whose ends
are hardly known along it.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from facetlog.errors import InconsistentViewsError
from facetlog.perception.detection.line_front_end.corner_tracks import Corners, track_corners
from facetlog.perception.detection.line_front_end.faces_from_lines import (
    Pictures,
    prepare_pictures,
    tracked_faces,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import project_points
from facetlog.perception.detection.line_front_end.side_fit import fit_sides
from facetlog.perception.detection.picture_faults import find_picture_fault
from facetlog.perception.detection.view_graph import measure_view_motion
from facetlog.perception.detection.working_size import to_own_pixels
from facetlog.perception.estimation.incidence import GATE
from facetlog.perception.estimation.lines.image_line import fit_image_line
from facetlog.perception.estimation.lines.space_line import fit_line_to_points
from facetlog.perception.estimation.plane_filter import fit_plane
from facetlog.perception.estimation.point_recursion import update_by_view
from facetlog.perception.estimation.pose_noise import compute_pixel_covs
from facetlog.perception.estimation.pose_refinement.refine_poses import correct_poses
from facetlog.perception.reading.read_views import ViewSet, collect_stated_errors
from facetlog.perception.scene import Evidence, Face, Scene
from facetlog.perception.stable_order import largest
from facetlog.perception.step_clock import StepClock
from facetlog.perception.surfaces.drawing.hidden_surface import (
    HiddenSurface,
    hidden_surface,
    is_facing_camera,
)
from facetlog.perception.surfaces.reconstruct import SceneOfFaces, make_scene_of_faces, reconstruct
from facetlog.perception.surfaces.scene_from_tracks import Stated
from facetlog.perception.types import FloatArray, PoseErrorKind, View

# Views that are kept with their pictures, as many as the paper's tour has: of the demo's table 12
# of them show six faces, all 24 nine (seed 0).
KEY_VIEWS = 24

# Faces are searched in three views and more, and again when so large a share of the kept views is
# new: seven searches for the first 24 views. Once views are let go, what they showed is mostly
# known, and a search takes as long as 25 views without: it comes with so many others, and after
# searches that changed nothing with twice as many each time.
LEAST_VIEWS = 3
NEW_SHARE = 1.0 / 3.0
OTHERS_SHARE = 2.0 / 3.0
# Corners of two searches are one if their distance would come up by noise once in so many.
SAME_CORNER = float(chdtri(3, 1e-5))
# A view contradicts what is known when it has most of at least so many corners elsewhere.
LEAST_READ = 4
# Places along a side that must be seen for it to be looked for.
PLACES = 5


@dataclass(frozen=True, eq=False, slots=True)
class CornerReadings:
    """Pixels (n, 2) of the scene's vertices with covariances (n, 2, 2), where `seen` (n,)."""

    uv: FloatArray
    cov: FloatArray
    seen: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class OneView:
    """A view with the covariance of its pose, what was found in its picture, and what faces hide.

    `hidden` is what the view sees of the faces of `scene`.
    """

    scene: Scene
    given: View
    looked: Pictures
    hidden: HiddenSurface

    @classmethod
    def of(cls, scene: Scene, given: View, looked: Pictures) -> "OneView":
        return cls(scene, given, looked, hidden_surface(looked.views[0], scene))

    def read_corners(self) -> CornerReadings:
        """Return where the view shows the vertices of measured faces: there its edges meet."""
        (view,), (edges,) = self.looked.views, self.looked.maps
        count = len(self.scene.vertices)
        readings = CornerReadings(
            np.zeros((count, 2)),
            np.tile(np.eye(2), (count, 1, 1)),
            np.zeros(count, np.bool_),
        )
        faces = [face for face in self.scene.faces if face.evidence is Evidence.MEASURED]
        if not faces:
            return readings
        corners = Corners(
            self.scene.points, tuple(f.outline for f in faces), tuple(tuple(f.holes) for f in faces)
        )
        turned = np.array([is_facing_camera(face, view) for face in faces])
        shown = corners.find_shown_side_views(turned[:, None])[:, 0] & self._find_sides_in_sight(
            corners.segments
        )
        fits = fit_sides(corners.segments, shown[:, None], [view], [edges])
        for vertex, track in enumerate(track_corners(corners, [view], fits)):
            for seen in to_own_pixels(track, self.looked.factors).observations:
                readings.uv[vertex], readings.cov[vertex] = seen.uv, seen.cov
                readings.seen[vertex] = True
        return readings

    def update_loose_lines(self, scene: Scene, extra_px: float, factor: float) -> tuple[Scene, int]:
        """Return the scene with its loose edges updated by the view, and how many were.

        `scene` has the faces and edges of the view's own. The variance of pixels is `factor` times
        one to which `extra_px` was added (scene_from_tracks.Assembled).
        """
        of_faces = {k for face in scene.faces for ring in (face.outline, *face.holes) for k in ring}
        loose = [e for e in scene.edges if not of_faces.intersection((e.start, e.end))]
        if not loose:
            return scene, 0
        (view,), (edges,) = self.looked.views, self.looked.maps
        ends = scene.points[np.array([(e.start, e.end) for e in loose])]
        (fits,) = fit_sides(ends, self._find_sides_in_sight(ends)[:, None], [view], [edges])
        vertices = list(scene.vertices)
        updated = 0
        for k in np.flatnonzero(fits.good).tolist():
            pair = loose[k].start, loose[k].end
            pixels, _ = project_points(view.projection, ends[k])
            pixels = pixels + fits.offset[k, :, None] * fits.normal[k]
            across = np.outer(fits.normal[k], fits.normal[k])
            # Along it the readings say nothing, and a line of them asks for nothing.
            noise = (fits.variance[k, :, None, None] + extra_px**2) * factor * across
            noise += (
                compute_pixel_covs(self.given, ends[k]) * float(np.mean(self.looked.factors)) ** 2
            )
            known = [vertices[n].cov for n in pair]
            line = fit_line_to_points(ends[k], known)
            line, chi2 = line.seen(fit_image_line(pixels, noise), view.projection)
            if chi2 > GATE:
                continue
            for n, point, cov in zip(pair, ends[k], known, strict=True):
                on, cov_on = line.near(point, cov)
                vertices[n] = replace(vertices[n], point=on, cov=cov_on)
            updated += 1
        return replace(scene, vertices=tuple(vertices)), updated

    def _find_sides_in_sight(self, sides: FloatArray) -> NDArray[np.bool_]:
        """Return which sides (n, 2, 3) no face hides from the view, (n,)."""
        share = ((np.arange(PLACES) + 0.5) / PLACES)[:, None]
        places = (sides[:, :1] + share * (sides[:, 1:] - sides[:, :1])).reshape(-1, 3)
        uv, depth = project_points(self.looked.views[0].projection, places)
        seen = self.hidden.visible(np.nan_to_num(uv), depth) & (depth > 0)
        return np.asarray(seen.reshape(-1, PLACES).all(axis=1), dtype=np.bool_)


@dataclass(frozen=True, eq=False, slots=True)
class Update:
    """The outcome of a view: whether it was `used`, a problem with it; whether faces were searched,
    and how many corners and loose edges it updated.

    A search may find that views which were taken contradict the others: `problem` names them when
    that is first seen. They may turn out right when more views have come.
    """

    used: bool
    problem: str = ""
    searched: bool = False
    corners: int = 0
    lines: int = 0


@dataclass(eq=False, slots=True)
class KeyViews:
    """Views (of any size) and what each shows; `changes` counts those taken since the
    last search, `complete` says that none was let go."""

    views: tuple[View, ...] = ()
    looked: Pictures | None = None
    changes: int = 0
    complete: bool = True

    def add(self, view: View, looked: Pictures) -> None:
        """Take a view; beyond KEY_VIEWS the one goes that is most like another."""
        self.views = (*self.views, view)
        self.looked = looked if self.looked is None else self.looked.extend_by(looked)
        self.changes += 1
        if len(self.views) <= KEY_VIEWS:
            return
        motion = measure_view_motion(self.views)
        np.fill_diagonal(motion, np.inf)
        # Of the two most alike the one goes whose next neighbour is nearer.
        nearest = np.sort(motion, axis=1)
        gone = largest(-nearest[:, 0], -nearest[:, 1])
        self.complete = False
        self.changes -= gone == len(self.views) - 1
        kept = [k for k in range(len(self.views)) if k != gone]
        self.views = tuple(self.views[k] for k in kept)
        self.looked = self.looked.select(kept)


class OnlineScene:
    """A scene that is known after each of the views that are added."""

    def __init__(
        self,
        *,
        name: str,
        up: FloatArray | None = None,
        find_up: bool = True,
        metric: bool = False,
        error_kind: PoseErrorKind = PoseErrorKind.ODOMETRY,
        clock: StepClock | None = None,
    ) -> None:
        self.scene: Scene | None = None
        self._name, self._up, self._metric = name, up, metric
        self._find_up = find_up
        self._error_kind = error_kind
        self.clock = clock or StepClock()
        self._key = KeyViews()
        self._found: SceneOfFaces | None = None
        self._searched, self._in_vain = 0, 0
        self._extra_px, self._factor = 0.0, 1.0
        self._touched: NDArray[np.bool_] = np.zeros(0, np.bool_)
        self._taken, self._contradicting = 0, 0
        self._refusals: list[str] = []
        self._named: set[str] = set()

    def add(self, view: View) -> Update:
        """Update the scene by one more view; a view that shows nothing or contradicts is
        named.
        """
        if (fault := find_picture_fault(view.image)) is not None:
            return self._refuse_view(f"{view.name}: {fault}")
        looked = prepare_pictures([view], self.clock)
        with self.clock.step("update"):
            corners = lines = 0
            if self.scene is not None and self.scene.faces:
                one = OneView.of(self.scene, view, looked)
                corners, problem = self._filter(view, one.read_corners())
                if problem:
                    return self._refuse_view(problem)
                self.scene, lines = one.update_loose_lines(self.scene, self._extra_px, self._factor)
            self._key.add(view, looked)
            self._taken += 1
        searched = len(self._key.views) >= LEAST_VIEWS and self._key.changes >= self._due()
        problem = self._search() if searched else ""
        return Update(True, problem, searched, corners, lines)

    def _refuse_view(self, problem: str) -> Update:
        self._refusals.append(problem)
        return Update(False, problem)

    def _due(self) -> float:
        # With how many changes of the kept views faces are searched anew.
        if self._key.complete:
            return max(1.0, NEW_SHARE * self._searched)
        return OTHERS_SHARE * self._searched * 2.0**self._in_vain

    @property
    def used(self) -> int:
        """How many views were taken and do not contradict the others, as far as is known."""
        return self._taken - self._contradicting

    @property
    def key_views(self) -> tuple[View, ...]:
        """The views that are kept with their pictures."""
        return self._key.views

    def finish(self, *, polish: bool) -> str:
        """Complete the scene by what each of the kept views saw, and polish it first or not.

        To polish is to reconstruct the kept views, which adjusts their poses, lenses and all
        corners together. If no view was let go the scene is then that of all views at once; else it
        stays as it is where the kept views alone show fewer faces or know their corners less well.
        Return what is to be said of the views, as `Update.problem`.
        """
        problem = ""
        if polish and len(self._key.views) >= LEAST_VIEWS:
            problem = self._polish()
        if self.scene is not None and self._found is not None:
            self.scene = self._found.complete(self.scene, self.clock)
            self._found = None
        if self.scene is not None:
            self.scene = replace(self.scene, warnings=(*self._refusals, *self.scene.warnings))
            self._refusals = []
        return problem

    def _polish(self) -> str:
        with self.clock.step("poses"):
            kept = self._refine_key_views()
        try:
            scene = reconstruct(
                kept.views,
                name=self._name,
                up=self._up,
                find_up=self._find_up,
                metric=self._metric,
                errors=kept.pose_errors,
                clock=self.clock,
            )
        except InconsistentViewsError as exc:
            return str(exc)
        before = self._before()
        # Of views that were let go the recursion alone knows.
        if before is None or _is_better_scene(scene, before):
            self.scene, self._touched = _keep_surer_corners(before, scene)
            self._found = None
        return "; ".join(kept.problems)

    def _refine_key_views(self) -> ViewSet:
        """Return the kept views, their poses corrected where they were counted up."""
        views = self._key.views
        errors = collect_stated_errors(views, self._error_kind)
        kept = ViewSet(self._name, views, metric=self._metric, pose_errors=errors)
        return kept if errors is None else correct_poses(kept)

    def _before(self) -> Scene | None:
        """Return the scene so far, where the recursion knows what the kept views do not show."""
        # To take the surer of two estimates from the same views would be to take the one too sure.
        return None if self._key.complete else self.scene

    def _filter(self, view: View, readings: CornerReadings) -> tuple[int, str]:
        scene = self.scene
        rows = np.flatnonzero(readings.seen)
        if scene is None or not len(rows):
            return 0, ""
        noise = self._factor * (readings.cov[rows] + self._extra_px**2 * np.eye(2))
        noise += compute_pixel_covs(view, scene.points[rows])
        covs = np.array([v.cov for v in scene.vertices])
        points, after, good = update_by_view(
            view.projection, scene.points[rows], covs[rows], readings.uv[rows], noise
        )
        if len(rows) >= LEAST_READ and 2 * good.sum() < len(rows):
            return 0, (
                f"{view.name} contradicts the views before: of {len(rows)} corners that it shows "
                f"{good.sum()} are where they should be; not used, check its pose"
            )
        vertices = list(scene.vertices)
        for k, point, cov in zip(rows[good], points[good], after[good], strict=True):
            vertices[k] = replace(vertices[k], point=point, cov=cov)
        self._touched[rows[good]] = True
        self.scene = _refitted(replace(scene, vertices=tuple(vertices)), self._touched)
        return int(good.sum()), ""

    def _search(self) -> str:
        # Returns what is wrong with the views, if they contradict one another.
        key, clock = self._key, self.clock
        if key.looked is None:
            return ""
        try:
            tracked = tracked_faces(key.looked, self._up, clock)
        except InconsistentViewsError as exc:
            return str(exc)
        finally:
            self._searched, key.changes = len(key.views), 0
        errors = collect_stated_errors(key.views, self._error_kind)
        stated = Stated(self._name, self._up, self._metric, errors=errors)
        found = make_scene_of_faces(tracked, key.views, stated, clock)
        self._found, made = found, found.assembled
        self._extra_px, self._factor = made.extra_px, made.factor
        self._in_vain = self._in_vain + 1 if _have_same_faces(self.scene, made.scene) else 0
        scene, self._touched = _keep_surer_corners(self._before(), made.scene)
        # Without the space that the views saw, what is behind a face would count as full.
        self.scene = found.seen(scene, clock)
        self._contradicting = len(key.views) - len(found.used)
        new = [line for line in tracked.warnings if line not in self._named]
        self._named.update(new)
        return "; ".join(new)


def _is_better_scene(scene: Scene, than: Scene) -> bool:
    if len(scene.faces) != len(than.faces):
        return len(scene.faces) > len(than.faces)
    spreads = [
        np.median([np.trace(s.vertices[k].cov) for f in s.faces for k in f.outline] or [np.inf])
        for s in (scene, than)
    ]
    return bool(spreads[0] <= spreads[1])


def _match_corners(old: Scene | None, new: Scene) -> dict[int, int]:
    """Return vertices of the new scene and those of the old one that they may be, each at most
    once.
    """
    if old is None or not old.vertices or not new.vertices:
        return {}
    before, after = ([v.cov for v in s.vertices] for s in (old, new))
    apart = new.points[:, None] - old.points[None]
    spread = np.array(after)[:, None] + np.array(before)[None]
    chi2 = np.einsum("mni,mni->mn", apart, np.linalg.solve(spread, apart[..., None])[..., 0])
    nearest, of = chi2.argmin(axis=1), chi2.argmin(axis=0)
    return {
        k: same
        for k, same in enumerate(nearest.tolist())
        if chi2[k, same] <= SAME_CORNER and of[same] == k
    }


def _have_same_faces(old: Scene | None, new: Scene) -> bool:
    """Return whether the faces of the new scene are those of the old one, corner by corner."""
    if old is None or len(old.faces) != len(new.faces):
        return False
    same = _match_corners(old, new)
    known = {frozenset(face.outline) for face in old.faces}
    return all(frozenset(map(same.get, face.outline)) in known for face in new.faces)


def _keep_surer_corners(old: Scene | None, new: Scene) -> tuple[Scene, NDArray[np.bool_]]:
    """Return the new scene with the corners of the old one where they are the same and surer."""
    touched = np.zeros(len(new.vertices), np.bool_)
    if old is None:
        return new, touched
    vertices = list(new.vertices)
    for k, same in _match_corners(old, new).items():
        kept = old.vertices[same]
        if np.trace(kept.cov) < np.trace(vertices[k].cov):
            vertices[k] = replace(vertices[k], point=kept.point, cov=kept.cov)
            touched[k] = True
    return _refitted(replace(new, vertices=tuple(vertices)), touched), touched


def _refitted(scene: Scene, touched: NDArray[np.bool_]) -> Scene:
    """Return the scene with the planes of the faces whose corners were updated."""
    return replace(scene, faces=tuple(_face(scene, f, touched) for f in scene.faces))


def _face(scene: Scene, face: Face, touched: NDArray[np.bool_]) -> Face:
    ring = list(face.outline)
    if not touched[ring].any():
        return face
    fit = fit_plane(scene.points[ring], np.array([scene.vertices[k].cov for k in ring]))
    if not fit:
        return face
    plane = fit.plane
    if plane.normal @ face.plane.normal < 0:
        plane = plane.flipped()
    return replace(face, plane=plane)

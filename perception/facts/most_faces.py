"""How many faces a scene may have to be judged: each pair of them is facts."""

from facetlog.errors import InputError
from facetlog.perception.scene import Scene

MOST_FACES = 2_000
"""For 600 faces `query` takes 440 MB, for 1,200 1.24 GB, most of it angles and offsets of
pairs, half of that in Python: some .75 kB a pair, 3 GB for so many faces."""


def check_face_count(scene: Scene, source: object) -> None:
    """Raise InputError, naming the `source`, if the scene has more faces than that."""
    count = len(scene.faces)
    if count > MOST_FACES:
        raise InputError(
            f"{source}: has {count:,} faces, of at most {MOST_FACES:,} facts are made, for each "
            "pair is one: leave out faces that do not matter"
        )

"""Solids made of cuboids and cylinders whose places are sums of a few sizes: what a prototype is
fitted as.

A leg that stands `rim` in from the end of a top that is `long` reaches from long - rim - leg to
long - rim: whatever the sizes, parts that touch go on to touch, and what is symmetric stays so.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Protocol

import numpy as np

from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.built_solids import Solid, build_solids
from facetlog.perception.surfaces.exact_solids.cuboid_union import cuboid_union
from facetlog.perception.types import FloatArray


class Form(Protocol):
    """A kind of solid with sizes that can be chosen."""

    @property
    def name(self) -> str:
        """Name in reports."""

    @property
    def grows(self) -> bool:
        """Whether more parts can be put to it."""

    @property
    def sizes(self) -> Mapping[str, float]:
        """Its sizes as it starts, metres or radians, all positive."""

    def scene(self, sizes: Mapping[str, float]) -> Scene:
        """Return the exact scene of these sizes; ValueError for sizes that nothing can have."""

    def described(self, sizes: Mapping[str, float]) -> str:
        """Return it and these sizes in words."""


@dataclass(frozen=True, slots=True)
class Length:
    """A sum of sizes, each so many times."""

    terms: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    def __add__(self, other: "Length") -> "Length":
        names = dict.fromkeys((*self.terms, *other.terms))
        return Length({n: self.terms.get(n, 0.0) + other.terms.get(n, 0.0) for n in names})

    def __mul__(self, factor: float) -> "Length":
        return Length({name: factor * count for name, count in self.terms.items()})

    def __sub__(self, other: "Length") -> "Length":
        return self + other * -1.0

    def of(self, sizes: Mapping[str, float]) -> float:
        """Return its value, metres."""
        return sum(count * sizes[name] for name, count in self.terms.items())


ZERO = Length()


@dataclass(frozen=True, slots=True)
class Part:
    """A cuboid: the ends of its extents along x, y and z.

    What is `round` fills its cuboid as the builder of this name does: `wheel` or `cylinder`.
    """

    x: tuple[Length, Length]
    y: tuple[Length, Length]
    z: tuple[Length, Length]
    round: str = ""

    @property
    def extents(self) -> tuple[tuple[Length, Length], ...]:
        """Its extents along the three axes."""
        return self.x, self.y, self.z


@dataclass(frozen=True, slots=True)
class Assembly:
    """Parts that are one solid, and the sizes at which fitting them begins.

    Parts that are not `joined` touch as bodies of their own, so that boards in one plane are two.
    """

    name: str
    sizes: Mapping[str, float]
    parts: tuple[Part, ...]
    joined: bool = True

    @property
    def grows(self) -> bool:
        """Whether more parts can be added."""
        return True

    def ends(self, sizes: Mapping[str, float]) -> FloatArray:
        """Return the lowest and the highest corner of each part (2, n, 3), metres."""
        found = [[[end.of(sizes) for end in along] for along in p.extents] for p in self.parts]
        return np.array(found).transpose(2, 0, 1)

    def scene(self, sizes: Mapping[str, float]) -> Scene:
        """Return the surface of all of it, standing on the ground; ValueError if a part has no
        extent.
        """
        low, high = self.ends(sizes)
        if not self.joined or any(part.round for part in self.parts):
            return self._build(low - low.min(axis=0), high - low)
        ground = np.array([0.0, 0.0, low[:, 2].min()])
        return cuboid_union(low - ground, high - ground, self.name)

    def _build(self, places: FloatArray, extents: FloatArray) -> Scene:
        """Return the scene of parts as bodies of their own, from their lowest corners (n, 3)."""
        solids = []
        for part, place, (x, y, z) in zip(self.parts, places, extents.tolist(), strict=True):
            sizes = {
                "": {"width": x, "depth": y, "height": z},
                "wheel": {"diameter": z, "thickness": y},
                "cylinder": {"diameter": x, "height": z},
            }[part.round]
            at = dict(zip("xyz", place.tolist(), strict=True))
            solids.append(Solid(part.round or "cuboid", sizes | at))
        return build_solids(solids, self.name)

    def described(self, sizes: Mapping[str, float]) -> str:
        """Return its parts, and then the sizes."""
        return f"{self.name}: {', '.join(f'{n} {100.0 * sizes[n]:.3g} cm' for n in self.sizes)}"

    def size(self, name: str, value: float) -> "tuple[Assembly, Length]":
        """Return the assembly with one more size, of this name or one like it, and that size."""
        free = next(n for n in (name, *(f"{name}{i}" for i in range(2, 99))) if n not in self.sizes)
        sizes = {**self.sizes, free: value}
        return replace(self, sizes=sizes), Length({free: 1.0})

    def also(self, word: str, parts: Sequence[Part]) -> "Assembly":
        """Return the assembly with more parts, which `word` adds to its name."""
        return replace(self, name=f"{self.name}, {word}", parts=(*self.parts, *parts))

    def raised(self, by: Length) -> "Assembly":
        """Return the assembly so much higher above the ground."""
        parts = tuple(replace(p, z=(p.z[0] + by, p.z[1] + by)) for p in self.parts)
        return replace(self, parts=parts)

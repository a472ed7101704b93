"""What knowledge bases leave in Prolog, and how it is cleared away when nobody asks it any more."""

from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from itertools import count

from facetlog.kb.engine.door import Door, clean_up
from facetlog.kb.engine.python_predicates import forget
from facetlog.kb.engine.terms import Atom, term_text

__all__ = ["Leftovers", "clear", "clear_all", "destroy_scene", "leave", "scene_module"]

_modules = count(1)
# Prolog keeps a few hundred bytes for each name that a module ever had: names are used again.
_free_modules: list[str] = []


@dataclass(frozen=True, slots=True)
class Leftovers:
    """Scenes and rules of a knowledge base by their modules, and its Python functions."""

    base: str
    door: Door
    scenes: tuple[str, ...]
    rules: tuple[str, ...]
    functions: tuple[int, ...]


# Of knowledge bases that were collected; the next request of another one clears it away.
_left: deque[Leftovers] = deque()


def scene_module() -> str:
    """The name of a module that no scene of this process has."""
    try:
        return _free_modules.pop()
    except IndexError:
        return f"facetlog_scene:{next(_modules)}"


def destroy_scene(door: Door, module: str) -> None:
    """Destroys a scene's module when all that is asked now has ended."""
    if door.when_quiet("destroy_scene", term_text(Atom(module)), state=module):
        _free_modules.append(module)


def leave(left: Leftovers) -> None:
    """Notes what is to be cleared away, without waiting for anything."""
    _left.append(left)


def clear_all() -> None:
    """Clears away what was noted."""
    while _left:
        with suppress(IndexError):
            clear(_left.popleft())


def clear(left: Leftovers) -> None:
    """Clear it away; what Prolog does not forget stays until the process ends."""
    clean_up(left.door, "forget_base", term_text(Atom(left.base)))
    for key in left.functions:
        forget(key)
    for module in left.scenes:
        destroy_scene(left.door, module)
    for module in left.rules:
        left.door.when_quiet("drop_rules", term_text(Atom(module)), state=module)

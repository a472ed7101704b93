"""The embedded SWI-Prolog: started once a process, the only importer of pyswip.

Python and Prolog meet in one predicate, request/4 of bridge.pl: an operation and a text in,
replies out, one for each solution. pyswip starts SWI-Prolog; the rest is said through the C
interface with its true types, since pyswip's queries may not be nested, interleaved or moved to
another thread, and its conversions cut large integers and text with NUL.
"""

import atexit
import ctypes
import locale
import logging
import os
import re
import sys
import threading
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from importlib import import_module
from importlib.resources import files
from importlib.util import find_spec, module_from_spec
from pathlib import Path
from typing import Any, TypeAlias

from facetlog.errors import EngineError
from facetlog.kb.engine.program import load_program
from facetlog.kb.engine.python_predicates import called

__all__ = [
    "MINIMUM_VERSION",
    "OK",
    "CrashError",
    "Engine",
    "Piece",
    "Reply",
    "decode_piece",
    "house",
    "start",
]

MINIMUM_VERSION = (9, 0, 4)
"""SWI-Prolog of Debian 12, the oldest that this was tried with."""

PLACES = ("LIBSWIPL_PATH", "SWI_HOME_DIR")
"""Variables of the environment that say where SWI-Prolog is."""

BOOT_FILE = "boot.prc"
"""File in SWI-Prolog's home; without it SWI-Prolog ends the whole process at start."""

LOCALE_VARIABLES = ("LC_ALL", "LC_CTYPE", "LANG")
"""Variables that set the text encoding, in order of precedence."""

UTF8_LOCALE = "C.UTF-8"

INSTALL_HINT = (
    "install SWI-Prolog 9.0.4 or newer (Debian and Ubuntu: apt install swi-prolog-nox; "
    "macOS: brew install swi-prolog)"
)

Piece: TypeAlias = bytes | str
"""One string of a reply: bytes if all its characters are below 256, else text."""

Reply: TypeAlias = tuple[Piece, ...]

_LOG = logging.getLogger(__name__)

OK = '["ok",'
"""How a reply begins that reports no error."""

# What Python offers to rules: an identifier and arguments as text in, a reply as text out.
Callback: TypeAlias = Callable[[str], str]


_SURROGATE = re.compile("[\ud800-\udfff]")
_PRIVATE = re.compile("[\U0010f000-\U0010f7ff]")
_TO_PRIVATE = 0x10F000 - 0xD800
"""From the surrogates to the last plane of Unicode, whose characters mean nothing by themselves."""


class CrashError(Exception):
    """A request ended with an exception that Prolog did not turn into a reply."""


class Engine:
    """SWI-Prolog's library, as one thread sees it that has attached itself.

    Its methods belong on the thread that started Prolog, and on threads that called `attach`.
    `version` is SWI-Prolog's: major, minor and patch.
    """

    # term_t, fid_t and qid_t are uintptr_t. Constants of SWI-Prolog.h.
    _TERM = ctypes.c_size_t
    _ATOM, _STRING, _UTF8 = 2, 6, 0x00100000
    _CATCH_EXCEPTION, _NODEBUG, _EXT_STATUS = 0x0008, 0x0004, 0x0040
    _EXCEPTION, _FALSE, _LAST = -1, 0, 2
    _CVT_STRING = 0x00000002
    _QUICKLY = 0x00010000 | 0x00020000  # no reclaiming of memory, no cancelling

    def __init__(self, library: ctypes.CDLL, version: tuple[int, int, int]) -> None:
        self.version = version

        def declare(name: str, result: type | None, *arguments: type) -> Any:
            return ctypes.CFUNCTYPE(result, *arguments)((name, library))

        term, text, pointer, number = self._TERM, ctypes.c_char_p, ctypes.c_void_p, ctypes.c_int
        size, int64 = ctypes.c_size_t, ctypes.c_int64
        chars, length = ctypes.POINTER(ctypes.c_void_p), ctypes.POINTER(size)
        self._attach = declare("PL_thread_attach_engine", number, pointer)
        self._detach = declare("PL_thread_destroy_engine", number)
        self._cleanup = declare("PL_cleanup", number, number)
        self._open_frame = declare("PL_open_foreign_frame", term)
        self._discard_frame = declare("PL_discard_foreign_frame", None, term)
        self._new_terms = declare("PL_new_term_refs", term, number)
        self._put_text = declare("PL_put_chars", number, term, number, size, text)
        self._put_integer = declare("PL_put_int64", number, term, int64)
        self._find_predicate = declare("PL_predicate", pointer, text, number, text)
        self._open_query = declare("PL_open_query", term, pointer, number, pointer, term)
        self._next = declare("PL_next_solution", number, term)
        self._close = declare("PL_close_query", number, term)
        self._get_list = declare("PL_get_list", number, term, term, term)
        self._get_text = declare("PL_get_nchars", number, term, length, chars, ctypes.c_uint)
        self._mark_strings = declare("PL_mark_string_buffers", None, ctypes.POINTER(term))
        self._release_strings = declare("PL_release_string_buffers_from_mark", None, term)
        self._unify_text = declare("PL_unify_chars", number, term, number, size, text)
        self._register = declare(
            "PL_register_foreign_in_module", number, text, text, number, pointer, number
        )
        self._request = None
        self._main_thread = threading.get_ident()
        self._kept: list[object] = []  # callbacks that C holds must not be collected

    @property
    def is_main_thread(self) -> bool:
        """Whether the calling thread is the one that started Prolog."""
        return threading.get_ident() == self._main_thread

    def attach(self) -> int:
        """Attach the calling thread, which then may call Prolog; return Prolog's number of it."""
        number = int(self._attach(None))
        if number < 0:
            raise EngineError("SWI-Prolog has no room for another thread")
        return number

    def detach(self) -> None:
        """Take the calling thread's Prolog away again."""
        self._detach()

    def stop(self) -> None:
        """End SWI-Prolog, on the thread that started it: at exit it would do so on another."""
        self._cleanup(self._QUICKLY)

    def run(self, module: str, predicate: str, *files: Path) -> bool:
        """Return whether a predicate of these arguments succeeds, and raises nothing."""
        frame = self._open_frame()
        try:
            terms = self._new_terms(len(files))
            for place, path in enumerate(files):
                self._put(terms + place, os.fsencode(path), self._ATOM)
            found = self._find_predicate(predicate.encode(), len(files), module.encode())
            query = self._open_query(None, self._CATCH_EXCEPTION, found, terms)
            try:
                return bool(self._next(query))
            finally:
                self._close(query)
        finally:
            self._discard_frame(frame)

    def register(self, module: str, name: str, callback: Callback) -> None:
        """Make `callback` the predicate module:name(+Text, -Reply)."""

        def called(text: int, reply: int) -> int:
            # Must not raise: ctypes would print the exception and go on with garbage.
            mark = self._TERM()
            self._mark_strings(ctypes.byref(mark))
            said = _encode(callback(decode_piece(self._read_piece(text))))
            self._release_strings(mark.value)
            kind = self._STRING | self._UTF8
            return int(self._unify_text(reply, kind, len(said), said))

        foreign = ctypes.CFUNCTYPE(ctypes.c_size_t, self._TERM, self._TERM)(called)
        self._kept.append(foreign)
        address = ctypes.cast(foreign, ctypes.c_void_p)
        if not self._register(module.encode(), name.encode(), 2, address, 0):
            raise EngineError(f"SWI-Prolog refuses the predicate {module}:{name}/2")

    def request(
        self, number: int, operation: str, text: str
    ) -> Generator[tuple[Reply, bool], None, None]:
        """Return each reply of request/4, and whether it is the last one; closing closes the query.

        Raise CrashError if Prolog raises.
        """
        if self._request is None:
            self._request = self._find_predicate(b"request", 4, b"facetlog_bridge")
        frame = self._open_frame()
        try:
            terms = self._new_terms(4)
            self._put_integer(terms, number)
            self._put(terms + 1, operation.encode())
            self._put(terms + 2, _encode(text))
            flags = self._CATCH_EXCEPTION | self._NODEBUG | self._EXT_STATUS
            query = self._open_query(None, flags, self._request, terms)
            try:
                status = None
                while status != self._LAST:
                    status = self._next(query)
                    if status == self._FALSE:
                        return
                    if status == self._EXCEPTION:
                        raise CrashError
                    # The scratch frame is discarded at once: a long answer must not pile up.
                    inner = self._open_frame()
                    mark = self._TERM()
                    self._mark_strings(ctypes.byref(mark))
                    try:
                        reply = tuple(self._pieces(terms + 3))
                    finally:
                        self._release_strings(mark.value)
                        self._discard_frame(inner)
                    yield reply, status == self._LAST
            finally:
                self._close(query)
        finally:
            self._discard_frame(frame)

    def _put(self, term: int, data: bytes, kind: int = _STRING) -> None:
        self._put_text(term, kind | self._UTF8, len(data), data)

    def _pieces(self, items: int) -> Iterator[Piece]:
        terms = self._new_terms(2)
        head, tail = terms, terms + 1
        source = items
        while self._get_list(source, head, tail):
            yield self._read_piece(head)
            source = tail

    def _read_piece(self, term: int) -> Piece:
        chars, length = ctypes.c_void_p(), ctypes.c_size_t()
        place = ctypes.byref(length), ctypes.byref(chars)
        # Without a flag for the encoding this is Latin-1, and refuses what does not fit.
        if self._get_text(term, *place, self._CVT_STRING):
            return ctypes.string_at(chars.value or 0, length.value)
        if self._get_text(term, *place, self._CVT_STRING | self._UTF8):
            return _decode(ctypes.string_at(chars.value or 0, length.value))
        raise EngineError("SWI-Prolog's reply is no text")


def _encode(text: str) -> bytes:
    """Return text as SWI-Prolog takes it: UTF-8, with lone surrogates as characters for private
    use.

    Python has names of files that are no UTF-8 as text with surrogates, which Prolog refuses.
    """
    try:
        return text.encode()
    except UnicodeEncodeError:
        return _SURROGATE.sub(lambda found: chr(ord(found[0]) + _TO_PRIVATE), text).encode()


def _decode(data: bytes) -> str:
    """Return text of SWI-Prolog as Python has it: see `_encode`."""
    text = data.decode("utf-8", "surrogatepass")
    return _PRIVATE.sub(lambda found: chr(ord(found[0]) - _TO_PRIVATE), text)


def decode_piece(piece: Piece) -> str:
    """Return the characters of a piece."""
    return piece if isinstance(piece, str) else piece.decode("latin-1")


_starting = threading.Lock()


def start() -> Engine:
    """Return the process's SWI-Prolog with bridge.pl loaded; the first caller's thread is its main
    one.

    Raise EngineError if it is missing, too old, or does not load.
    """
    with _starting:
        return _started()


@cache
def _started() -> Engine:
    with _prepare_environment():
        return _load_engine()


def _load_engine() -> Engine:
    try:
        core = _pyswip_core()
    except Exception as exc:
        raise EngineError(_why_not_started(exc)) from exc
    version = _version(core.PL_VERSION)
    if version < MINIMUM_VERSION:
        written = ".".join(map(str, version))
        raise EngineError(f"SWI-Prolog {written} is too old: {INSTALL_HINT}")
    engine = Engine(core._lib, version)
    if not load_program(engine, version, house("kb").parent):
        raise EngineError("the knowledge base's own Prolog files cannot be loaded")
    engine.register("facetlog_bridge", "python", called)
    return engine


def _why_not_started(exc: Exception) -> str:
    """Say what keeps SWI-Prolog from starting, and the way out."""
    said = " ".join(str(exc).split()) or type(exc).__name__
    # pyswip's own errors, whose classes cannot be imported where it fails.
    if type(exc).__name__ == "SwiPrologNotFoundError":
        return f"SWI-Prolog is missing: {INSTALL_HINT}"
    if "is required" in said and "swi-prolog" in said.lower():
        return f"SWI-Prolog is too old ({said}): {INSTALL_HINT}"
    if isinstance(exc, ImportError):
        return f"pyswip cannot be imported ({said}): pip install --force-reinstall pyswip"
    if isinstance(exc, MemoryError):
        return "SWI-Prolog does not start: it gets no memory; allow more, or end other programs"
    if isinstance(exc, OSError):
        places = [name for name in PLACES if os.environ.get(name)]
        hint = f": unset {' and '.join(places)}" if places else f": {INSTALL_HINT}"
        return f"SWI-Prolog's library cannot be loaded ({said}){hint}"
    return f"SWI-Prolog does not start ({type(exc).__name__}: {said})"


def _pyswip_core() -> Any:
    """Return pyswip's interface to C, with SWI-Prolog started, without signal handlers.

    Who started it stops it (engine_pool.py). pyswip would at the end of the process, on another
    thread, and SWI-Prolog crashes where that is still in the middle of its start: a Ctrl-C may end
    the process at any time. So pyswip is kept from it before it starts Prolog, which to import the
    package does at once: the package is there by its name first, and runs its code last.
    """
    if "pyswip" in sys.modules or (spec := find_spec("pyswip")) is None:
        import pyswip  # or why it cannot be

        del pyswip
    else:
        package = sys.modules["pyswip"] = module_from_spec(spec)
        try:
            atexit.unregister(import_module("pyswip.core").cleanupProlog)
            if spec.loader is not None:
                spec.loader.exec_module(package)
        except BaseException:
            del sys.modules["pyswip"]
            raise
    core = import_module("pyswip.core")
    atexit.unregister(core.cleanupProlog)
    return core


def _version(number: int) -> tuple[int, int, int]:
    """Return major, minor and patch of SWI-Prolog's version number.

    >>> _version(90004)
    (9, 0, 4)
    """
    return number // 10000, number // 100 % 100, number % 100


def house(room: str) -> Path:
    """Return the folder of a room of the program: Prolog loads files by path."""
    return Path(str(files(f"facetlog.{room}"))).resolve()


# ---- the environment in which SWI-Prolog starts, whatever the user's is


@contextmanager
def _prepare_environment() -> Iterator[None]:
    """Give SWI-Prolog a current folder, a home that is one, and UTF-8 for its files' names."""
    with ExitStack() as stack:
        stack.enter_context(_ensure_current_folder())
        stack.enter_context(_hide_arguments())
        home = os.environ.get("SWI_HOME_DIR")
        if home is not None and not (Path(home) / BOOT_FILE).is_file():
            _LOG.warning(
                "SWI_HOME_DIR=%s is no home of SWI-Prolog (no %s): ignored", home, BOOT_FILE
            )
            stack.enter_context(_change_environment({"SWI_HOME_DIR": None}))
        stack.enter_context(_ensure_utf8())
        yield


@contextmanager
def _ensure_current_folder() -> Iterator[None]:
    """Stay in / if the current folder was deleted: SWI-Prolog crashes there."""
    try:
        Path.cwd()
    except OSError:
        pass
    else:
        yield
        return
    descriptor = -1
    with suppress(OSError):
        descriptor = os.open(".", os.O_RDONLY)
    os.chdir(os.sep)
    try:
        yield
    finally:
        if descriptor >= 0:
            # To where paths that others hold may lead again.
            with suppress(OSError):
                os.fchdir(descriptor)
            os.close(descriptor)


@contextmanager
def _hide_arguments() -> Iterator[None]:
    """Hide the command line, which pyswip encodes as UTF-8 and nobody reads: names may be none."""
    before = sys.argv
    sys.argv = ["facetlog"]
    try:
        yield
    finally:
        sys.argv = before


@contextmanager
def _ensure_utf8() -> Iterator[None]:
    """Have SWI-Prolog take text for UTF-8, as all our files are, whatever the locale."""
    stated = next((os.environ[name] for name in LOCALE_VARIABLES if os.environ.get(name)), "C")
    if "utf" in stated.lower() or not _is_known(UTF8_LOCALE):
        yield
        return
    changes: dict[str, str | None] = {"LC_CTYPE": UTF8_LOCALE}
    if os.environ.get("LC_ALL"):
        changes |= {"LC_ALL": None, "LANG": os.environ["LC_ALL"]}
    with _change_environment(changes):
        yield


def _is_known(name: str) -> bool:
    before = locale.setlocale(locale.LC_CTYPE)
    try:
        locale.setlocale(locale.LC_CTYPE, name)
    except locale.Error:
        return False
    locale.setlocale(locale.LC_CTYPE, before)
    return True


@contextmanager
def _change_environment(changes: dict[str, str | None]) -> Iterator[None]:
    """Change variables of the environment, None to unset one, and put them back."""
    before = {name: os.environ.get(name) for name in changes}
    _set_environment(changes)
    try:
        yield
    finally:
        _set_environment(before)


def _set_environment(values: dict[str, str | None]) -> None:
    for name, value in values.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value

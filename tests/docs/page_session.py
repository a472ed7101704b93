"""A folder in which the blocks of a page are tried one after the other."""

import io
import re
import shlex
from collections.abc import Iterable, Iterator
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path

from facetlog.cli import main
from facetlog.grammar.analysis import analyse
from facetlog.grammar.library import BUILTIN
from tests.docs.page_blocks import Block, blocks, commands, matches

__all__ = ["Outcome", "Session"]

_TIMES = re.compile(r"step .* s|.* \d+\.\d+ +\d+\.\d+")
"""A line of the table of times: its head, or a step with two numbers of seconds."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of one block or command: its line, and what is not as the page says."""

    line: int
    what: str
    problem: str = ""


@dataclass(slots=True)
class Session:
    """Tries the blocks of a page in a folder, in which `rules` leads to the built-in models."""

    folder: Path
    slow: bool
    _mistaken: dict[str, str] = field(default_factory=dict)

    def outcomes(self, page: str) -> Iterator[Outcome]:
        """Try each block in turn, and yield its result."""
        link = self.folder / "rules"
        if not link.exists():
            link.symlink_to(BUILTIN, target_is_directory=True)
        found = list(blocks(page))
        for block, after in zip(found, [*found[1:], None], strict=True):
            with chdir(self.folder):
                yield from self._tried(block, after)

    def _tried(self, block: Block, after: Block | None) -> Iterable[Outcome]:
        match block.language:
            case "model":
                return (self._model(block, after),)
            case "prolog" if block.file is not None:
                Path(block.file).write_text(block.text, encoding="utf-8")
                # Words alone are tried by the models that use them.
                problem = _loaded(block.file) if "\nmodel(" in block.text else ""
                return (Outcome(block.line, block.file, problem),)
            case "python" if "slow" in block.info and not self.slow:
                return ()
            case "python":
                exec(compile(block.text, f"line {block.line}", "exec"), {})  # noqa: S102
                return (Outcome(block.line, "python"),)
            case "console":
                return tuple(self._console(block))
            case "" | "toml":
                return ()
        return (Outcome(block.line, block.language, "no test reads blocks of this kind"),)

    def _model(self, block: Block, after: Block | None) -> Outcome:
        name = block.file
        if name is None:
            lines = f"model sample\n{block.parts.replace('; ', chr(10))}\n{block.text}"
            return Outcome(block.line, "lines", _errors("sample.model", lines))
        path = Path(name)
        before = path.read_text(encoding="utf-8") if path.exists() else ""
        text = before + block.text if "+" in block.info else block.text
        path.write_text(text, encoding="utf-8")
        if "mistaken" in block.info:
            self._mistaken.setdefault(name, before)
        shown = after is not None and after.text.startswith(f"$ facetlog model check {name}\n")
        return Outcome(block.line, name, "" if shown else _errors(name, text))

    def _console(self, block: Block) -> Iterator[Outcome]:
        for command in commands(block):
            if command.slow and not self.slow:
                continue
            program, *words = shlex.split(command.words)
            if program != "facetlog":
                yield Outcome(command.line, command.words, f"{program} is not run by the tests")
                continue
            got = said(words)
            right = matches(command.output, got)
            problem = "" if right else f"the page says\n{command.output}\nit printed\n{got}"
            yield Outcome(command.line, command.words, problem)
        for name, text in self._mistaken.items():
            Path(name).write_text(text, encoding="utf-8")
        self._mistaken.clear()


def said(words: list[str]) -> str:
    """Return what a command prints, and then its messages without the times it took."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        main(words)
    told = [line for line in err.getvalue().splitlines() if not _TIMES.fullmatch(line)]
    text = out.getvalue() + "".join(f"{line}\n" for line in told)
    return text.replace(f"{Path.cwd()}/", "")


def _errors(name: str, text: str) -> str:
    errors = analyse(Path(name), text).errors
    return "\n".join(f"{fault.place}: {fault.message}" for fault in errors)


def _loaded(name: str) -> str:
    """Load a Prolog file; return what is wrong with it, empty if nothing is."""
    from facetlog.errors import FacetlogError
    from facetlog.kb.knowledge_base import KnowledgeBase

    with KnowledgeBase() as base:
        try:
            base.load_rules(Path(name), trusted=True)
        except FacetlogError as exc:
            return str(exc)
    return ""

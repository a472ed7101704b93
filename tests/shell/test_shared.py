"""What every command of the line does with the errors of its body."""

from collections.abc import Callable

import pytest
import typer

from facetlog.commands.shared import command
from facetlog.errors import EngineError


def _raising(error: BaseException) -> Callable[[], None]:
    @command
    def body() -> int:
        raise error

    return body


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (EngineError("it stopped"), 3, "it stopped"),
        (RecursionError("maximum recursion depth"), 2, "what was given is nested too deeply"),
        (MemoryError(), 2, "what was given needs more memory than there is: give less at once"),
        (KeyboardInterrupt(), 130, ""),
    ],
)
def test_an_error_is_one_line_and_an_exit_code(
    error: BaseException, code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(typer.Exit) as ended:
        _raising(error)()
    assert ended.value.exit_code == code
    assert capsys.readouterr().err == (f"facetlog: {said}\n" if said else "")

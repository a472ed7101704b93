"""Linear algebra on one thread, unless the user asks for more."""

import os

import pytest

from facetlog import __main__, cli
from facetlog.one_thread import ONE_THREAD


def test_the_command_line_takes_one_thread_where_the_user_says_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ONE_THREAD:
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    monkeypatch.setattr(cli, "main", lambda _: 0)
    with pytest.raises(SystemExit):
        __main__.run()
    assert {name: os.environ[name] for name in ONE_THREAD} == {
        **dict.fromkeys(ONE_THREAD, "1"),
        "OMP_NUM_THREADS": "3",
    }

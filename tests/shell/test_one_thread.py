"""Linear algebra on one thread, unless the user asks for more."""

import os

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from facetlog import __main__, cli
from facetlog.one_thread import ONE_THREAD, use_one_thread


def test_the_command_line_takes_one_thread_where_the_user_says_nothing(monkeypatch):
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


def count_blas_threads() -> set[int]:
    assert np.linalg.inv(np.eye(2)).any()  # loaded
    return {info["num_threads"] for info in threadpool_info() if info["user_api"] == "blas"}


def test_a_python_program_has_its_own_number_of_threads_again_afterwards():
    with threadpool_limits(2, user_api="blas"):
        before = count_blas_threads()
        with use_one_thread():
            assert count_blas_threads() == {1}
        assert count_blas_threads() == before

"""`facetlog model new`: a file to start from."""

import pytest


@pytest.mark.parametrize("name", ["coffee_table", "coffee_table.model"])
def test_a_new_model_passes_its_check_layout_and_examples(name, run):
    file = "coffee_table.model"
    assert run("model", "new", name) == (0, f"{file}\n", "")
    assert run("model", "check", file, "--warnings-as-errors")[0] == 0
    assert run("model", "format", "--check", file)[0] == 0
    assert "2 examples, 2 passed" in run("model", "test", file)[1]


def test_a_file_that_exists_is_left_as_it_is(refused, tmp_path):
    (tmp_path / "bench.model").write_text("mine")
    assert "is there already" in refused("model", "new", "bench")
    assert (tmp_path / "bench.model").read_text() == "mine"


@pytest.mark.parametrize("name", ["pair", "two words", "3legs", "a\nmodel b", "", "a-b"])
def test_a_name_that_the_language_does_not_have_is_refused(name, refused, tmp_path):
    refused("model", "new", name)
    assert not list(tmp_path.iterdir())

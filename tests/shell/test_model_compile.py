"""`facetlog model compile`: the forms of a model file."""

import pytest

from facetlog.kb.knowledge_base import KnowledgeBase

MODEL = 'model slab\n  "A board."\n  face top\n  level: top is level, top is upward  "it is flat"\n'
MODEL += '  example "board" of cuboid(height 2 cm) holds\n'


@pytest.fixture(autouse=True)
def models(tmp_path):
    (tmp_path / "slab.model").write_text(MODEL)
    (tmp_path / "faulty.model").write_text(MODEL.replace("upward", "upwrad"))


def test_prolog_is_a_rule_file_that_can_be_loaded(run, tmp_path):
    for again in ((), ("--overwrite",)):
        assert run("model", "compile", "slab.model", "-o", "slab.pl", *again) == (0, "", "")
    with KnowledgeBase() as base:
        assert base.load_rules(tmp_path / "slab.pl", trusted=True).models == ("slab",)


@pytest.mark.parametrize(
    ("form", "lines"),
    [
        ("tree", ["  part", "reference\ttop\n", "    level\n"]),
        ("ast", ["Model 1:7\n", "  doc: Text 2:3 value='A board.'\n", "  statements: Line 4:3"]),
        ("clauses", ['model(slab, "A board.", [top]).\n']),
    ],
)
def test_each_form_can_be_shown(form, lines, run):
    code, out, _ = run("model", "compile", "slab.model", "--emit", form)
    assert code == 0
    assert all(line in out for line in lines), out


@pytest.mark.parametrize("form", ["clauses", "prolog", "tree", "ast"])
def test_a_faulty_file_has_no_clauses_and_is_shown_as_far_as_it_goes(form, run, tmp_path):
    code, out, err = run("model", "compile", "faulty.model", "--emit", form)
    assert code == 1
    assert bool(out) == (form in ("tree", "ast"))
    assert "faulty.model:4:31: error: " in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["slab.model", "-o", "./slab.model"], "is what is read"),
        (["gone.model"], "gone.model: the file cannot be read"),
        (["."], "names 2 files: give one"),
    ],
)
def test_what_cannot_be_compiled_is_refused(arguments, message, refused, tmp_path):
    assert message in refused("model", "compile", *arguments)
    assert (tmp_path / "slab.model").read_text() == MODEL

"""Test that faulty shape files are refused with a reason, and docs/shapes.md lists all suffixes."""

from pathlib import Path

from facetlog.perception.reading.shape_files.suffixes import CLOUD_SUFFIXES, MESH_SUFFIXES

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "shapes.md").read_text(encoding="utf-8")


def test_the_page_lists_all_kinds_of_files():
    section = PAGE.partition("\n## Files\n")[2].partition("\n\n**")[0]
    for suffix in (*MESH_SUFFIXES, *CLOUD_SUFFIXES, ".json"):
        assert f"`{suffix}`" in section


def test_all_documents_are_in_the_index():
    index = (DOCS / "README.md").read_text(encoding="utf-8")
    documents = {p.name for p in DOCS.iterdir() if p.suffix in (".md", ".json")} - {"README.md"}
    assert {name for name in documents if f"[{name}]({name})" not in index} == set()

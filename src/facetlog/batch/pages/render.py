"""Pages of a run from their templates, a piece at a time."""

from collections.abc import Iterator
from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined

from facetlog import __version__
from facetlog.page.policy import make_head_lines
from facetlog.terminal import printable


def render_page(template: str, **values: object) -> Iterator[bytes]:
    """Return the page of a template, in pieces; names in it are escaped and have no controls."""
    environment = Environment(
        loader=PackageLoader(__package__ or "", ""),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=lambda value: printable(value) if type(value) is str and value != "\n" else value,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    style = files(__package__).joinpath("report.css").read_text(encoding="utf-8")
    head = make_head_lines(version=__version__)
    pieces = environment.get_template(template).generate(
        **values, head=head, style=style, version=__version__
    )
    return (piece.encode("utf-8", "backslashreplace") for piece in pieces)

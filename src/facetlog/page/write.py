"""The page as a file: no other file and no network is needed to look at it."""

from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from facetlog import __version__
from facetlog.page.contents import Subject, contents
from facetlog.page.policy import find_scripts, make_head_lines
from facetlog.terminal import printable

PAGE_FILE = "report.html"


def page(subject: Subject) -> str:
    """Return the page of a run, or of what was asked of a scene, as text."""
    environment = Environment(
        loader=PackageLoader(__package__ or "", ""),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_printable,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    beside = {
        name: files(__package__).joinpath(file).read_text(encoding="utf-8")
        for name, file in (("style", "page.css"), ("script", "page.js"))
    }
    template = environment.get_template("page.html.jinja")
    shown = contents(subject)
    # A page of its own, whose lines are kept.
    scripts = (beside["script"], *find_scripts(shown["model_view"]))
    shown["model_view"] = escape(shown["model_view"])
    return template.render(**shown, **beside, head=make_head_lines(scripts, version=__version__))


def _printable(value: object) -> object:
    """Return what a name in the page must not have (control characters, half a letter) as
    spaces.
    """
    return printable(value) if isinstance(value, str) and not isinstance(value, Markup) else value

"""The language server: what editors ask of model files, over stdio."""

from types import MappingProxyType

from facetlog.errors import make_missing_extra_error
from facetlog.grammar.example_scenes import Builders


def run(builders: Builders = MappingProxyType({})) -> None:
    """Serve one editor over stdin and stdout until it says `exit` or closes them.

    `builders` are what examples can build; without any the examples' scenes are not checked.

    InputError where pygls is not installed.
    """
    # Only who serves an editor loads its protocol.
    try:
        from facetlog.grammar.language_server.server import build_model_server
    except ModuleNotFoundError as exc:
        raise make_missing_extra_error("the language server", "pygls", "editor") from exc

    build_model_server(builders).start_io()

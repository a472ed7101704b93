"""`facetlog model lsp`: the language server for editors."""

from facetlog.commands.shared import YES, command

__all__ = ["lsp_command"]


@command
def lsp_command() -> int:
    """Serves an editor over standard input and output, until it says so or closes them."""
    from facetlog.commands.model.scenes import builder_sizes
    from facetlog.grammar.language_server import run

    run(builder_sizes())
    return YES

"""What the call that is being written takes, and which argument the cursor stands in."""

from collections.abc import Sequence

from lsprotocol import types as lsp

from facetlog.grammar.analysis import Analysis
from facetlog.grammar.language_server import Builders
from facetlog.grammar.language_server.context import context_at
from facetlog.grammar.language_server.documentation import word_documentation
from facetlog.grammar.reading.layout import Token

__all__ = ["TRIGGERS", "signature_help"]

TRIGGERS = ("(", ",")


def signature_help(
    analysis: Analysis, text: str, offset: int, builders: Builders
) -> lsp.SignatureHelp | None:
    """The word, definition or builder in whose brackets a place stands; None if in no one's."""
    context = context_at(text, offset)
    call = _open_call(context.tokens) if context is not None else None
    if context is None or call is None:
        return None
    name, number, of_builder = call
    if of_builder:
        sizes = list(builders.get(name, ()))
        return _help(name, sizes, "", number, "") if sizes else None
    model = analysis.all_models.get(context.model)
    defines = model.defines if model is not None else {}
    if name in defines:
        node = defines[name].node
        says = node.doc.value if node.doc is not None else ""
        return _help(name, [p.text for p in node.parameters], "", number, says)
    if name == "count":
        return _help(name, ["set"], ": count", number, "how many members a set has")
    word = analysis.words.get(name)
    if word is None:
        return None
    inside, _, gives = word.signature.removeprefix(f"{name}(").rpartition("): ")
    return _help(name, inside.split(", "), f": {gives}", number, word_documentation(word))


def _open_call(tokens: Sequence[Token]) -> tuple[str, int, bool] | None:
    """The name before the innermost open bracket, the commas behind it, and whether it is built."""
    depth = commas = 0
    for i in range(len(tokens) - 1, 0, -1):
        sign = tokens[i].text
        if sign == ")":
            depth += 1
        elif sign == "," and depth == 0:
            commas += 1
        elif sign == "(" and depth > 0:
            depth -= 1
        elif sign == "(":
            if tokens[i - 1].kind != "word":
                return None
            built = tokens[0].text == "example" and i > 1 and tokens[i - 2].text == "of"
            return tokens[i - 1].text, commas, built
    return None


def _help(
    name: str, arguments: Sequence[str], gives: str, number: int, says: str
) -> lsp.SignatureHelp:
    label = f"{name}({', '.join(arguments)}){gives}"
    parameters = [lsp.ParameterInformation(argument) for argument in arguments]
    text = lsp.MarkupContent(lsp.MarkupKind.Markdown, says) if says else None
    active = min(number, max(len(arguments) - 1, 0))
    one = lsp.SignatureInformation(label, text, parameters, active)
    return lsp.SignatureHelp([one], active_signature=0, active_parameter=active)

"""What each kind of fault of a model file is, for readers of reports."""

from collections.abc import Mapping
from types import MappingProxyType

from facetlog.grammar.fault_codes import FAULT_KINDS

__all__ = ["FAULT_CODES", "described"]

FAULT_CODES: Mapping[str, str] = MappingProxyType(
    {kind.code: kind.meaning for kind in FAULT_KINDS.values()}
)
"""One sentence for each kind of fault."""


def described(code: str) -> str:
    """One sentence on a kind of fault; its own name, spelt out, for one not yet listed."""
    return FAULT_CODES.get(code) or f"{code.replace('-', ' ').capitalize()}."

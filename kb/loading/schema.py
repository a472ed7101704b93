"""The facts' schema, as Prolog is given it when it starts."""

from facetlog.kb.engine.terms import Atom, Struct, term_text
from facetlog.perception.facts.fact_schema import FACT_SCHEMA

__all__ = ["declarations"]


def declarations() -> str:
    """The declarations of all facts, for declare_facts/1 of schema.pl."""
    return term_text(
        tuple(
            Struct(
                "declared",
                (
                    Atom(kind.functor),
                    tuple(Struct("-", (Atom(a.name), Atom(a.kind.value))) for a in kind.arguments),
                    kind.meaning,
                ),
            )
            for kind in FACT_SCHEMA
        )
    )

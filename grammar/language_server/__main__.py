"""`python -m facetlog.grammar.language_server` serves an editor over stdio."""

from facetlog.grammar.language_server import run

if __name__ == "__main__":
    run()

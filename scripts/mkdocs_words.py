"""MkDocs hook: adds the page of all words of models and questions."""

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from facetlog.glossary import format_markdown, list_entries


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add words.md, made from the tables of the program."""
    files.append(File.generated(config, "words.md", content=format_markdown(list_entries())))
    return files

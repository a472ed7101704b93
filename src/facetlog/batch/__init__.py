"""Many scenes classified: worker processes, a journal, tables of results, and what came of them."""

"""Model text into checked clauses (the language is not built yet)."""

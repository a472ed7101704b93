"""The model language: text → tree → syntax → checked models → clauses → Prolog text."""

"""Checked models into clauses: conditions into tests, parts into joins, sets into searches."""

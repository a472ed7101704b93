"""Lint: conditions that never hold or are repeated, and names that are not used."""

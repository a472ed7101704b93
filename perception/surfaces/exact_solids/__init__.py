"""Exact scenes of known solids: the truth of tests, demos and examples."""

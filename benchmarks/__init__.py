"""What facetlog finds, how exactly and how fast: one file, one question.

`python -m benchmarks` runs all of them, `python -m benchmarks accuracy_demo --seeds 3` one of
them, and `--write` keeps what was measured in benchmarks/results and makes docs/benchmarks.md.
"""

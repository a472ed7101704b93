"""Verdicts and why: proofs and origins as data, and in words for those who do not program."""

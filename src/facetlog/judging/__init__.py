"""Verdicts on a collection while it grows, from a process of their own."""

"""Tests of the pieces of things."""

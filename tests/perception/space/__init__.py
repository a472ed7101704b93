"""Tests of the space of things."""

"""Texture points: corner features matched over the views and triangulated."""

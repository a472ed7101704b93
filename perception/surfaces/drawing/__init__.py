"""Scenes drawn into the views in which they were found."""

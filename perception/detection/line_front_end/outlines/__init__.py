"""Outlines on a plane that may be faces."""

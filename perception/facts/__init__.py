"""Scenes into facts: the schema, and what is measured for it."""

"""Pages of a run: the report of what went wrong, and a page for each scene."""

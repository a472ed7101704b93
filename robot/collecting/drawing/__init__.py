"""The picture of a collection: floor, way, views, and what was recognised."""

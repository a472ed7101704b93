"""Exact solid parts of closed triangle meshes, by planes and edges of their own."""

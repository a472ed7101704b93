"""Camera heads: what they are told and say as bytes, and their drivers."""

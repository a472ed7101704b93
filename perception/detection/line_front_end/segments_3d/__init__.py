"""3-D segments that many views support."""

"""Pictures into edges, segments and tracked faces, by one of two front ends."""

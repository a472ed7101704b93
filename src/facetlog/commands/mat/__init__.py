"""`facetlog mat`: the mat to print, and whether pictures of it suffice."""

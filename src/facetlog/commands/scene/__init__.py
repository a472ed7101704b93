"""`facetlog scene`: what scenes and raw shapes hold, in other forms, and whether it is sound."""

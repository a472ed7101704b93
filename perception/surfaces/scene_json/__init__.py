"""The format `facetlog-scene/1`: its records, their faults, and the scenes made of them."""

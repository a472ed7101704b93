"""What `facetlog-scene/1` consists of: its records, their faults, and the scene they tell of."""

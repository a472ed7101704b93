"""What Python programs and notebooks use: the names that `facetlog` itself exports."""

"""The commands `facetlog model ...`: what people who write models need."""

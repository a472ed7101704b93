"""From a model to a thing: solids that satisfy it, and solids that just do not."""

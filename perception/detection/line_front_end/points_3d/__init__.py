"""Points of print: features of texture matched over the views and triangulated."""

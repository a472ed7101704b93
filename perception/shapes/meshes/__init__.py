"""A mesh into flat regions and the rest: cleaned, taken apart, its outside found."""

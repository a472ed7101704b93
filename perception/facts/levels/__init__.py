"""Space at, beneath and above the level of a face, filled or left free by things."""

"""What the views say of a surface: its inside by their agreement, its sides by edges."""

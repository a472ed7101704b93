"""Evidence of the views for a surface: photo-consistency inside, edges along its sides."""

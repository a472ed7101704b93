"""Names and dimensions: whether every word of a model is known and is given what it takes."""

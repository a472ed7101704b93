"""Questions that need no search, answered from a scene's facts as numpy arrays."""

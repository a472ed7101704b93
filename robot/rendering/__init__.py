"""The simulated camera: worlds of flat faces, and pictures of them from any pose."""

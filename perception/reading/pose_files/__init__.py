"""Files that give each picture its camera and pose, one module for each kind."""

"""What views see: of faces and of the ground how much, and how far along which lines of sight."""

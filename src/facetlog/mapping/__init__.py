"""The map of a room: which things stand where, and which floor is free, occupied or unseen."""

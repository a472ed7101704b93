"""The simulated robot in its world: how it moves, what it runs into, what its sonars measure."""

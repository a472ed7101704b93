"""Where the camera head sits on the robot: the chain from its axle to the pinhole, and its fit."""

"""What a robot finds that decides itself where to look from."""

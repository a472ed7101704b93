"""Collections as recordings that other programs play: MCAP for ROS 2 tools, Rerun."""

"""Collections as MCAP recordings for ROS 2 tools."""

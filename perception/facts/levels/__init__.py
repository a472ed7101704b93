"""What lies at, beneath and above the level of a face: what things fill, and what they leave."""

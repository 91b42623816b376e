"""ROS 2 bags, and other MCAP files, as LeRobot datasets."""

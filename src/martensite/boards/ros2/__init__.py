"""A package for ROS 2: a `ros2_control` hardware interface around the link, and its messages."""

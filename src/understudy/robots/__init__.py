"""Real robots as bodies: ROS 2 without an installation of ROS (extra `ros2`)."""

"""Skills of real robots: actions and services of ROS 2 as basic behaviors, with their outcomes as readings."""

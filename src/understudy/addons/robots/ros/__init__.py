"""ROS 2 messages, topics and transports (DDS and Zenoh)."""

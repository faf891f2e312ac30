"""The demo in RViz: ``messages`` for either ROS, ``ros1`` and ``ros2`` for one each. Only ``ros/`` knows quaternions as xyzw."""

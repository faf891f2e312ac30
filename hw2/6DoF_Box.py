"""The movable box with an arrow and a ring for each axis, in RViz (hw2.launch). The light: test_collision_detection.py."""

from ulna.cli.quiet_imports import quiet_imports

with quiet_imports():  # Ctrl-C meanwhile ends the script without a traceback
    from ulna.demo.ros.adapter import ros1_or_exit

if __name__ == "__main__":
    ros1_or_exit().serve_box()

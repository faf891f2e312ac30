"""Shows the movable box in RViz (hw2.launch), with an arrow and a ring for each axis.

The collision light is that of test_collision_detection.py.
"""

from ulna.cli.quiet_imports import quiet_imports

with quiet_imports():  # Ctrl-C during the imports ends the script without a traceback
    from ulna.demo.ros.adapter import ros1_or_exit

if __name__ == "__main__":
    ros1_or_exit().serve_box()

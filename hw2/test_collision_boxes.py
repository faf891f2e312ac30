"""Shows the arm at q = 0 in RViz (roslaunch hw2.launch). Its boxes are shown by collision_boxes.py."""

from ulna.cli.quiet_imports import quiet_imports

with quiet_imports():  # Ctrl-C during the imports ends the script without a traceback
    import numpy as np

    from ulna.demo.ros.adapter import ros1_or_exit

if __name__ == "__main__":
    ros1_or_exit().hold_arm(np.zeros(7))

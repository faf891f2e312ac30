"""The arm at q = 0, in RViz (roslaunch hw2.launch); its boxes: collision_boxes.py."""

import numpy as np

from ulna.demo.ros.adapter import ros1_or_exit

if __name__ == "__main__":
    ros1_or_exit().hold_arm(np.zeros(7))

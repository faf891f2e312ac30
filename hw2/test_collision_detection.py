"""The arm repeats its trajectory in RViz (roslaunch hw2.launch), and the light is red while the box touches it.

The box is 6DoF_Box.py's; drag it by its arrows and rings.
"""

from ulna.cli.quiet_imports import quiet_imports

with quiet_imports():  # Ctrl-C meanwhile ends the script without a traceback
    from ulna.demo.ros.adapter import ros1_or_exit

if __name__ == "__main__":
    ros1_or_exit().play_arm()

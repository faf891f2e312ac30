"""Repeats the arm's trajectory in RViz (roslaunch hw2.launch), with a light that is red while the box touches the arm.

6DoF_Box.py shows the box. Drag it by its arrows and rings.
"""

from ulna.cli.quiet_imports import quiet_imports

with quiet_imports():  # Ctrl-C during the imports ends the script without a traceback
    from ulna.demo.ros.adapter import ros1_or_exit

if __name__ == "__main__":
    ros1_or_exit().play_arm()

#!/bin/sh
# Prints the arm for RViz: the expanded URDF with the finger joints, since franka_robot.urdf only defines a macro. roslaunch runs in a terminal
# without the virtual environment. So the script also tries the environments that the README and ros.md make, in this folder and in the one above.
# One that fails prints its reason, and the script tries the next. Without the meshes RViz shows the arm as boxes.
here=$(dirname "$0")
for ulna in "${ULNA:-ulna}" "$VIRTUAL_ENV/bin/ulna" \
    "$here/.venv-ros1/bin/ulna" "$here/.venv/bin/ulna" "$here/venv/bin/ulna" \
    "$here/../.venv-ros1/bin/ulna" "$here/../.venv/bin/ulna"; do
    if command -v "$ulna" >/dev/null && text=$("$ulna" ros1 description); then
        printf '%s\n' "$text"
        exit
    fi
done
echo "no ulna was found that can print the robot: run ULNA=/path/to/venv/bin/ulna roslaunch hw2.launch; without ROS, ulna demo shows the same scene in a browser" >&2
exit 1

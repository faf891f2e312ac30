#!/bin/sh
# Prints the arm for RViz: expanded URDF with the finger joints, for franka_robot.urdf only defines a macro. roslaunch runs in a terminal without the
# virtual environment, so ulna is also looked for in the usual places: the environments that the README and ros.md make, in this
# folder or in the one above; one that fails says why, and the next is tried. Without the meshes the arm is seen by its boxes.
here=$(dirname "$0")
for ulna in "${ULNA:-ulna}" "$VIRTUAL_ENV/bin/ulna" \
    "$here/.venv-ros1/bin/ulna" "$here/.venv/bin/ulna" "$here/venv/bin/ulna" \
    "$here/../.venv-ros1/bin/ulna" "$here/../.venv/bin/ulna"; do
    if command -v "$ulna" >/dev/null && text=$("$ulna" ros1 description); then
        printf '%s\n' "$text"
        exit
    fi
done
echo "no ulna is found that prints it: ULNA=/path/to/venv/bin/ulna roslaunch hw2.launch; the same in the browser, without ROS: ulna demo" >&2
exit 1

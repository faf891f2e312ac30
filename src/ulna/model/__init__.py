"""What a robot is, as frozen data: shapes, links, joints, and the kinematic tree in flat arrays."""

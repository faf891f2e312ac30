from pathlib import Path

ROOT = Path(__file__).parents[3]


def test_the_xacro_reader_is_tested_with_the_file_of_the_course():
    course = (ROOT / "hw2" / "franka_robot.urdf").read_bytes()
    assert course == (ROOT / "tests" / "description" / "data" / "franka_robot.urdf").read_bytes()

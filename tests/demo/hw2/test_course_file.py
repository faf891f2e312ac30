from pathlib import Path

ROOT = Path(__file__).parents[3]


def test_the_test_data_of_the_xacro_reader_is_the_course_file():
    course = (ROOT / "hw2" / "franka_robot.urdf").read_bytes()
    assert course == (ROOT / "tests" / "description" / "data" / "franka_robot.urdf").read_bytes()

"""Columns of tables by their names: in the order of the file, in the unit that the name states, or refused."""

import pytest

from ulna.description.columns import RPY, TIMES, WXYZ, XYZ, fields_of, find_columns, head_of, number_of, text_of

KNOWN = (*XYZ, *RPY, *WXYZ, TIMES)


def numbers(text, known=XYZ):
    """The names of a table, and its first row."""
    lines = text.splitlines()
    head = head_of(lines, known)
    fields = fields_of(lines[head.first], head.separator)
    return head.names, [number_of(field, head) for field in fields]


@pytest.mark.parametrize(
    "text",
    [
        "x,y,z\n1,2.5,3\n",
        "x, y, z\n1, 2.5, 3\n",
        "x;y;z\n1;2.5;3\n",
        "x;y;z\n1,0;2,5;3\n",
        "x\ty\tz\n1\t2,5\t3\n",
        "x y z\n  1   2.5 3 \n",
        "# x y z\n1 2.5 3\n",
        "# made by hand\n\n# columns: x y z\n1 2.5 3\n",
        "//x y z\n1 2.5 3\n",
        "# x, y, z\n1 2.5 3\n",
        '"x","y","z"\n"1","2.5","3"\n',
        "sep=;\nx;y;z\n1;2.5;3\n",
        "x,y,z,\n1,2.5,3,\n",
        "x,y,z\r\n1,2.5,3\r\n",
    ],
)
def test_separators_comments_and_decimal_commas_are_told_apart(text):
    for content in (text.encode(), text.encode("utf-8-sig"), text.encode("utf-16")):
        assert numbers(text_of(content)) == (("x", "y", "z"), [1.0, 2.5, 3.0])


@pytest.mark.parametrize("text", ["1,2.5,3\n", "1;2.5;3", "1;2,5;3", "# prose about nothing\n1 2.5 3", "\n\n1 2.5 3\n"])
def test_a_table_without_names_has_none(text):
    assert numbers(text) == (None, [1.0, 2.5, 3.0])


@pytest.mark.parametrize("text", ["", "\n", "# x y z\n", "x,y,z\n"])
def test_a_table_without_numbers_has_no_head(text):
    assert head_of(text.splitlines(), XYZ) is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x,y,z\n1,0,2,0,3,0\n", "line 1 has 3 names, but line 2 has 6 columns"),
        ("# intensity x y z\n1 2 3 4 5\n", "names 4 columns, but there are 5"),
    ],
)
def test_names_that_are_not_as_many_as_the_columns_are_refused(text, message):
    with pytest.raises(ValueError, match=message):
        head_of(text.splitlines(), XYZ)


@pytest.mark.parametrize(
    ("field", "decimal_comma"), [("1_0", False), ("1,5", False), ("1.5", True), ("1.234,5", True), ("", False)]
)
def test_what_is_no_number_is_none(field, decimal_comma):
    head = head_of(["1 2"], XYZ)
    with pytest.raises(ValueError):
        number_of(field, head._replace(decimal_comma=decimal_comma))


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("x", ("x", None)),
        (" X ", ("x", None)),
        ("x [mm]", ("x", 1e-3)),
        ("x(cm)", ("x", 1e-2)),
        ("x_mm", ("x", 1e-3)),
        ("x in mm", ("x", 1e-3)),
        ("x/m", ("x", 1.0)),
        ("pos_x", ("x", None)),
        ("field.pose.position.x", ("x", None)),
        ("/tf/base/hand/translation/x", ("x", None)),
        ("tx", ("x", None)),
        ("Points:0", ("x", None)),
        ("field.pose.orientation.w", ("qw", None)),
        ("/odom/orientation/x", ("qx", None)),
        ("q_w", ("qw", None)),
        ("Roll (deg)", ("roll", 0.017453292519943295)),
        ("yaw [\u00b0]", ("yaw", 0.017453292519943295)),
        ("pitch\u00b0", ("pitch", 0.017453292519943295)),
        ("t [ms]", ("time", 1e-3)),
        ("%time", ("time", 1e-9)),
        ("nx", None),
        ("linear.x", None),
        ("normal_x", None),
        ("rx", None),
        ("x\u00b2", None),
        ("intensity [dB]", None),
        ("", None),
    ],
)
def test_a_name_is_that_of_a_quantity_with_its_unit_or_of_none(name, found):
    columns = find_columns(["beside", name], KNOWN)
    assert dict(columns.at) == ({} if found is None else {found[0]: (1, found[1])})


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["x", "y", "x"], "'x' and 'x' are both x"),
        (["X", "x"], "both x"),
        (["actual.position.x", "goal.position.x"], "both x"),
        (["x [deg]"], r"the unit of column 'x \[deg\]' is not known; of x it may be m"),
        (["x [parsec]"], "is not known"),
        (["roll [mm]"], "is not known"),
        (["qw [deg]"], "is not known"),
    ],
)
def test_names_that_contradict_are_refused(names, message):
    with pytest.raises(ValueError, match=message):
        find_columns(names, KNOWN)


def test_a_line_of_a_million_characters_is_refused_before_it_is_split():
    with pytest.raises(ValueError, match="a line has 1000001 characters; up to 1000000 are read"):
        head_of(["," * 1_000_001], frozenset())

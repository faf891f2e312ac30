"""Maps that are damaged, or that a stranger made: each is read as it should be, or refused with an error of Ulna's."""

import json
import os
import shutil

import numpy as np
import pytest

import ulna
from map_files import verdicts_of

VALUES = (None, 5, "x", [], {}, -1, 1e308, float("nan"), True, "9" * 5000, [1e18] * 3, [10**9] * 3)
LAYOUTS = {
    "another type": {"data_type": "float64", "fill_value": 0.0},
    "texts": {"data_type": "string", "fill_value": ""},
    "a huge shape": {"shape": [10**6] * 4},
    "a small shape": {"shape": [1] * 4},
    "a pickled codec": {"codecs": [{"name": "numcodecs.pickle", "configuration": {}}]},
    "an unknown codec": {"codecs": [{"name": "evil"}]},
    "a huge chunk": {"chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [10**5] * 4}}},
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory, planar):
    path = tmp_path_factory.mktemp("maps") / "planar.zarr"
    ulna.reachability_map(planar, path, voxel=1.0, orientations=4)
    return path


@pytest.fixture
def path(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "map.zarr")
    return tmp_path / "map.zarr"


def change(file, **values):
    data = json.loads(file.read_text())
    data.get("attributes" if file.parent.suffix else "none", data).update(values)
    file.write_text(json.dumps(data))


def read_all(path):
    found = ulna.ReachabilityMap.open(path)
    T = np.eye(4)
    T[0, 3] = 1.5
    return found.summary, found.score(T), found.reached(T), found.world, found.attributes, repr(found)


def assert_refused(path, words=""):
    with pytest.raises(ulna.UlnaError, match=words) as caught:
        read_all(path)
    assert len(str(caught.value)) < 1000


def test_a_whole_map_is_read(path):
    summary, score, reached, *_ = read_all(path)
    assert summary.computed == summary.poses
    assert 0 <= score <= 1
    assert isinstance(reached, bool)


@pytest.mark.slow
@pytest.mark.parametrize("value", VALUES, ids=lambda value: str(value)[:12])
def test_an_attribute_of_any_value_is_read_or_refused(path, whole, value):
    attributes = json.loads((whole / "zarr.json").read_text())["attributes"]
    for name in attributes:
        shutil.copy(whole / "zarr.json", path / "zarr.json")
        change(path / "zarr.json", **{name: value})
        try:
            read_all(path)
        except ulna.UlnaError as error:
            assert len(str(error)) < 1000, name  # noqa: PT017


@pytest.mark.parametrize("layout", LAYOUTS)
def test_verdicts_of_another_layout_are_refused(path, layout):
    change(path / "reached" / "zarr.json", **LAYOUTS[layout])
    assert_refused(path, "the map's arrays cannot be opened: ")


def test_a_pipe_in_place_of_a_chunk_is_refused(path):
    for file in verdicts_of(path):
        file.unlink()
        os.mkfifo(file)
    assert_refused(path, "is not a regular file")


@pytest.mark.parametrize("name", ["zarr.json", "reached/zarr.json"])
def test_a_pipe_in_place_of_metadata_is_refused(path, name):
    (path / name).unlink()
    os.mkfifo(path / name)
    assert_refused(path, "not a regular file")


@pytest.mark.parametrize("other", ["/dev/zero", "/etc/passwd"])
def test_a_chunk_that_is_a_link_to_something_else_is_refused(path, other):
    for file in verdicts_of(path):
        file.unlink()
        file.symlink_to(other)
    assert_refused(path, "is not a regular file" if other == "/dev/zero" else "cannot be read")


@pytest.mark.parametrize("content", [b"", b"junk", b"\x28\xb5\x2f\xfd\xe4" + b"\xff" * 12])
def test_a_damaged_chunk_is_refused_and_the_file_is_named_which_can_be_computed_again(path, planar, content):
    first = verdicts_of(path)[0]
    good = first.read_bytes()
    first.write_bytes(content)
    assert_refused(path, r"reached/c/.*cannot be read .*remove this file, and resume=True \(--resume\) computes it again$")
    first.unlink()
    ulna.reachability_map(planar, path, voxel=1.0, orientations=4, resume=True)
    assert first.read_bytes() == good


@pytest.mark.parametrize("text", ["[" * 100_000, '{"attributes":' * 900 + "1" + "}" * 900, "[]", "5", '{"attributes": []}'])
def test_metadata_that_are_not_those_of_a_map_are_refused(path, text):
    (path / "zarr.json").write_text(text)
    assert_refused(path, "is not a reachability map")

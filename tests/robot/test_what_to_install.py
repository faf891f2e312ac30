"""The command by which an extra is installed is one that works for this copy: no package index has Ulna."""

import json
import re
import shlex
from pathlib import Path

import pytest

import ulna
from ulna.errors import count_of, install_command

ROOT = Path(__file__).parents[2]
METADATA = """Metadata-Version: 2.4
Name: ulna
Version: 0.1.0
Provides-Extra: viewer
Requires-Dist: numpy>=1.26
Requires-Dist: viser>=1.1; extra == 'viewer'
Requires-Dist: dask[distributed]>=2025.1; extra == "reach"
"""


@pytest.fixture
def installed(tmp_path):
    """A function that makes an installed copy of a package, and returns its folder; url: where pip says that it came from."""

    def install(url=None):
        package, info = tmp_path / "site" / "ulna", tmp_path / "site" / "ulna-0.1.0.dist-info"
        for folder in (package, info):
            folder.mkdir(parents=True, exist_ok=True)
        (info / "METADATA").write_text(METADATA)
        (info / "direct_url.json").unlink(missing_ok=True)
        if url is not None:
            (info / "direct_url.json").write_text(json.dumps({"url": url}))
        return package

    return install


def test_a_clone_is_installed_again_with_the_extra(tmp_path, monkeypatch):
    package = tmp_path / "my clone" / "src" / "ulna"
    package.mkdir(parents=True)
    (tmp_path / "my clone" / "pyproject.toml").write_text('[project]\nname = "ulna"\n')
    assert shlex.split(install_command("viewer", package)) == ["pip", "install", "-e", f"{tmp_path / 'my clone'}[viewer]"]
    monkeypatch.chdir(tmp_path / "my clone")
    assert install_command("viewer", package) == 'pip install -e ".[viewer]"'


def test_a_wheel_is_installed_again_with_the_extra_as_long_as_it_is_there(tmp_path, installed):
    wheel = tmp_path / "ulna-0.1.0-py3-none-any.whl"
    wheel.touch()
    package = installed(wheel.as_uri())
    assert shlex.split(install_command("viewer", package)) == ["pip", "install", f"{wheel}[viewer]"]
    wheel.unlink()
    assert shlex.split(install_command("viewer", package)) == ["pip", "install", "viser>=1.1"]


@pytest.mark.parametrize("url", [None, "https://example.org/ulna-0.1.0-py3-none-any.whl"])
def test_of_a_copy_from_elsewhere_the_packages_of_the_extra_are_named(installed, url):
    package = installed(url)
    assert shlex.split(install_command("viewer", package)) == ["pip", "install", "viser>=1.1"]
    assert shlex.split(install_command("reach", package)) == ["pip", "install", "dask[distributed]>=2025.1"]


def test_the_error_of_a_missing_extra_has_the_command():
    assert str(ulna.MissingExtraError("the view", "viewer")) == f"the view needs the viewer extra: {install_command('viewer')}"


def test_nothing_tells_a_reader_to_install_a_package_that_anybody_could_register():
    files = [*(ROOT / "src").rglob("*.py"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "docs").rglob("*.ipynb"), *ROOT.glob("*.md")]
    files += (ROOT / "examples").rglob("*.py")
    assert len(files) > 300
    told = re.compile(r"pip install (-\S+ )*['\"\\]*ulna\b")
    assert [str(file) for file in files if told.search(file.read_text(encoding="utf-8"))] == []


def test_one_thing_is_not_many():
    assert [count_of(n, "pair") for n in (0, 1, 2)] == ["0 pairs", "1 pair", "2 pairs"]
    assert [count_of(n, "entry", "entries") for n in (1, 2)] == ["1 entry", "2 entries"]

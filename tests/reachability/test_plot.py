import sys

import matplotlib as mpl
import numpy as np
import pytest

import ulna
from ulna.cli.output import write_figure
from ulna.reachability.plot import draw

mpl.use("agg")
pytestmark = pytest.mark.filterwarnings("ignore:FigureCanvasAgg is non-interactive")


def test_a_figure_shows_the_shares_and_the_statuses(panda_map):
    figure = draw(panda_map)
    cut = figure.axes[1].images[0]
    y = float(figure.axes[1].get_title().removeprefix("y = ").removesuffix(" m"))
    below, above = (panda_map.share.sel(y=y, method=way).transpose("z", "x").values for way in ("ffill", "bfill"))
    shown = cut.get_array()
    assert (shown >= np.minimum(below, above) - 1e-12).all()
    assert (shown <= np.maximum(below, above) + 1e-12).all()
    assert all(axes.get_aspect() == 1.0 for axes in figure.axes[:3])
    low_x, high_x, low_z, high_z = cut.get_extent()
    assert high_x - low_x == pytest.approx(7 * 0.3)
    assert high_z - low_z == pytest.approx(7 * 0.3)
    assert {label.get_text() for label in figure.axes[5].get_yticklabels()} == {"reached", "unreachable", "budget spent"}


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_a_figure_is_written(panda_map, tmp_path, ending):
    write_figure(draw(panda_map), tmp_path / f"m.{ending}")
    assert (tmp_path / f"m.{ending}").stat().st_size > 5000


def test_what_cannot_be_written_is_refused(panda_map, tmp_path):
    with pytest.raises(ulna.InputError, match="out: "):
        write_figure(draw(panda_map), tmp_path / "m.hologram", "out")
    with pytest.raises(ulna.FileError, match="nowhere"):
        write_figure(draw(panda_map), tmp_path / "nowhere" / "m.png")


@pytest.mark.parametrize("missing", ["zarr", "xarray", "distributed"])
def test_without_the_extra_the_error_says_what_to_install(panda, panda_map, tmp_path, monkeypatch, missing):
    monkeypatch.setitem(sys.modules, missing, None)

    def ask():
        if missing == "xarray":
            return ulna.ReachabilityMap.open(panda_map.path).share
        return ulna.reachability_map(panda, tmp_path / "m.zarr", voxel=0.5, orientations=1, client=object())

    with pytest.raises(ulna.MissingExtraError, match=r"needs the reach extra: pip install "):
        ask()
    assert list(tmp_path.iterdir()) == []

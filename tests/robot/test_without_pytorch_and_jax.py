"""Without PyTorch or JAX, importing what needs it says which extra to install."""

import importlib
import sys

import pytest

import ulna

FILES = {"torch": "ulna.learning.tensors", "jax": "ulna.learning.callbacks"}


@pytest.mark.parametrize("library", FILES)
def test_the_error_names_the_extra(library, monkeypatch):
    for name in (f"ulna.{library}", FILES[library]):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setitem(sys.modules, library, None)  # as if it were not installed
    with pytest.raises(ulna.MissingExtraError, match=rf"ulna\.{library} needs the {library} extra: pip install") as caught:
        importlib.import_module(f"ulna.{library}")
    assert caught.value.extra == library

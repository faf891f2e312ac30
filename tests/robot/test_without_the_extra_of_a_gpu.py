"""What a person sees who asks for a GPU without the extra."""

import pytest

import ulna
from ulna.gpu import device


@pytest.mark.parametrize("float32", [False, True])
def test_the_missing_extra_is_named(monkeypatch, float32):
    monkeypatch.setattr(device, "cuda", None)
    with pytest.raises(ulna.MissingExtraError, match=r"needs the cuda13 extra: pip install "):
        ulna.load("panda").on_gpu(float32=float32)

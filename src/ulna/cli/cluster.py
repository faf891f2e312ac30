"""Connects to a Dask cluster."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from ulna.errors import ClusterError, needs_extra

_CONNECT_S = 10.0


@contextmanager
def client_of(address: str | None) -> Iterator[Any]:
    """A client of the cluster at an address; None without one.

    Raises:
        ClusterError: No scheduler is there.
        MissingExtraError: The extra ``reach`` is not installed.
    """
    if address is None:
        yield None
        return
    with needs_extra("a Dask cluster", "reach", "dask", "distributed"):
        from distributed import Client  # noqa: PLC0415 -- needs the extra
    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise ClusterError(f"no scheduler can be reached at {address} ({error})") from None
    try:
        yield client
    finally:
        with suppress(Exception):
            client.close(timeout=1.0)

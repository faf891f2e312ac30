"""Lists the robots that come with Ulna, by name. Used by ``load`` and ``by_name``."""

from dataclasses import dataclass
from importlib import resources

from ulna.description.names import panda


@dataclass(frozen=True)
class Bundled:
    """A bundled description: its file beside this module, and the configuration to start from [rad or m]."""

    file: str
    home: tuple[float, ...]

    def text(self) -> bytes:
        """The URDF document."""
        return resources.files("ulna.description.names").joinpath(self.file).read_bytes()


BUNDLED = {"panda": Bundled("panda.urdf", panda.HOME)}

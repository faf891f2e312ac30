"""Lists the robots that come with Ulna, by name."""

from dataclasses import dataclass
from pathlib import Path

from ulna.description.names import panda


@dataclass(frozen=True)
class Bundled:
    """A bundled description: its file beside this module, and the configuration to start from [rad or m]."""

    file: str
    home: tuple[float, ...]

    def text(self) -> bytes:
        """The URDF document."""
        return Path(__file__).with_name(self.file).read_bytes()


BUNDLED = {"panda": Bundled("panda.urdf", panda.HOME)}

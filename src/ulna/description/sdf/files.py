"""Opens the models that an SDF document includes, within its readable folders and with limits of cost."""

from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from ulna.description.document import Document
from ulna.description.file_bytes import regular_file_bytes
from ulna.description.meshes.mesh_files import MeshFiles
from ulna.description.packages import places
from ulna.description.sdf.frames import Place
from ulna.description.xml import LONGEST, MAX_ELEMENTS, parse, without_namespace
from ulna.errors import DescriptionError, FileError

MAX_INCLUDES = 200  # each counted as often as it is included
_LONGEST_ADDRESS = 1000
_FILES = (".sdf", ".world", ".xml", ".urdf")


@dataclass(frozen=True)
class Included:
    """A file that another includes.

    Attributes:
        path: Its path.
        root: Its root element.
        base: The address of its folder as seen from the document.
        above: The file that includes it; None for the document.
    """

    path: Path
    root: etree._Element
    base: str
    above: "Included | None"

    def address(self, uri: str) -> str:
        """An address in the file as seen from the document: a relative one is relative to the file."""
        if "://" in uri or uri.startswith(("/", "file:", "$(")):
            return uri
        return f"{self.base}/{uri}"


class ModelFiles:
    """Finds and reads the models that a document includes, each file once."""

    def __init__(self, document: Document) -> None:
        self.files = MeshFiles(document)
        self.document = None if document.folder is None else (document.folder / document.file).resolve()
        self.roots: dict[Path, etree._Element] = {}
        self.n_includes, self.n_elements, self.n_bytes = 0, 0, 0

    def included(self, uri: str, above: Included | None, place: Place) -> Included:
        """Read the file of an include.

        Raises:
            DescriptionError: It includes itself, is not XML, or the includes are too many or too long.
            FileError: It is missing, or may not be read.
        """
        self.n_includes += 1
        if self.n_includes > MAX_INCLUDES:
            raise place.fail(f"more than {MAX_INCLUDES} models are included")
        if len(uri) > _LONGEST_ADDRESS:
            raise place.fail(f"its address is longer than {_LONGEST_ADDRESS} letters")
        address = (uri if above is None else above.address(uri)).rstrip("/")
        path = self.located(address) if address.endswith(_FILES) else self.of_folder(address)
        path, one = path.resolve(), above
        base = address.rpartition("/")[0] if address.endswith(_FILES) else address
        base = base or "."
        while one is not None and one.path != path:
            one = one.above
        if one is not None or path == self.document:
            raise place.fail("the file includes itself")
        root = self.root(path)
        self.n_elements += sum(1 for _ in root.iter())
        if self.n_elements > MAX_ELEMENTS:
            raise place.fail(f"more than {MAX_ELEMENTS} elements are included")
        return Included(path, root, base, above)

    def located(self, address: str) -> Path:
        """The file of an address; a model must be found by its name, not by another file near the document."""
        path, files = self.files.located(address), self.files
        scheme, _, rest = address.partition("://")
        if scheme in ("model", "package") and places(address, files.folder, files.package_dirs).get(path) is None:
            name = rest.partition("/")[0]
            raise FileError(address, f"no such file; package_dirs=[...] names the folder that contains the model {name!r}")
        return path

    def root(self, path: Path) -> etree._Element:
        """The root element of a file."""
        if path not in self.roots:
            try:
                text = regular_file_bytes(path, LONGEST - self.n_bytes)
            except OSError as error:
                raise FileError(str(path), error.strerror or str(error)) from None
            self.n_bytes += len(text)
            if self.n_bytes > LONGEST:
                raise FileError(str(path), f"with the other models is longer than {LONGEST / 1e6:.0f} MB, up to which are read")
            self.roots[path] = without_namespace(parse(text, path.name))
        return self.roots[path]

    def of_folder(self, address: str) -> Path:
        """The SDF file of a model's folder: the newest version in its ``model.config``, or ``model.sdf``."""
        try:
            config = self.root(self.located(f"{address}/model.config"))
        except FileError as error:
            try:
                return self.located(f"{address}/model.sdf")
            except FileError:
                raise error from None
        named = [(_version(one), (one.text or "").strip()) for one in config.iterfind("sdf")]
        if not named:
            raise DescriptionError("names no <sdf>", f"{address}/model.config")
        return self.located(f"{address}/{max(named)[1]}")


def _version(element: etree._Element) -> tuple[int, ...]:
    words = element.get("version", "").split(".")
    return (
        tuple(int(word) for word in words) if all(word.isascii() and word.isdigit() and len(word) < 5 for word in words) else ()
    )

"""Defines every error that Ulna raises: an ``UlnaError`` that is a built-in too, with its data.

Each says where and what next, and carries its data as attributes.
"""

import json
import os
import re
import reprlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any, NoReturn

_PACKAGE = Path(__file__).resolve().parent
_LONGEST = 1000  # characters of a message, which may cite a document
MAX_CITED = 200  # characters of a value that is refused
_QUOTED = re.compile(rf"'[^']{{{MAX_CITED - 1},}}+'|\"[^\"]{{{MAX_CITED - 1},}}+\"")
_LONGEST_NAME, _MAX_NAMES = 100, 10_000  # among which near ones are looked for
# Arguments that some functions had, and what took their place.
_SUCCESSORS = {
    "method": "the search is Levenberg-Marquardt's; lesson 3 (docs/lessons/3_inverse_kinematics.ipynb) has the textbook methods "
    "in NumPy, hw2/franka_robot.py the Jacobian transpose",
    "threads": "ulna.threads(n) sets how many threads are used at most, from now on or in a with block",
}


class UlnaError(Exception):
    """The root of all errors of this library."""


class DescriptionError(UlnaError, ValueError):
    """A robot description that cannot be understood. ``source`` is its name, ``line`` where in it (or None)."""

    def __init__(self, message: str, source: str = "", line: int | None = None) -> None:
        message = _shortened(message)
        place = ":".join(str(part) for part in (source, line) if part not in ("", None))
        super().__init__(f"{place}: {message}" if place else message)
        self.message, self.source, self.line = message, source, line

    def __reduce__(self):
        return type(self), (self.message, self.source, self.line)


class DescriptionWarning(UserWarning):
    """Parts of a description that are not used: references to unknown links, and what is not read and may change a result."""


class UnitWarning(UserWarning):
    """Lengths or angles that are more likely in another unit than metres and radians, such as millimetres or degrees."""


class CompilerWarning(UserWarning):
    """Parts of Numba that the engine uses and this version lacks; entries are compiled without them. ``missing`` names them."""

    def __init__(self, message: str, missing: Iterable[str] = ()) -> None:
        super().__init__(message)
        self.missing = tuple(missing)


class InputError(UlnaError, ValueError):
    """A number, an array or an option that a function cannot take. ``argument`` names it."""

    def __init__(self, argument: str, message: str) -> None:
        message = _shortened(message)
        super().__init__(f"{argument}: {message}")
        self.argument, self.message = argument, message

    def __reduce__(self):
        return type(self), (self.argument, self.message)


class UnknownArgumentError(UlnaError, TypeError):
    """A keyword argument that a function does not have. ``argument`` is its name, ``function`` that of the function."""

    def __init__(self, function: str, argument: str, hint: str = "") -> None:
        super().__init__(f"{function}() got an unexpected keyword argument {argument!r}{hint and f'; {hint}'}")
        self.function, self.argument, self.hint = function, argument, hint

    def __reduce__(self):
        return type(self), (self.function, self.argument, self.hint)


def refuse_unknown(function: str, unknown: Iterable[str], hint: str = "") -> NoReturn:
    """Refuse the first of some arguments that a function does not have; of a former one the successor is named.

    Raises:
        UnknownArgumentError: Always. ``hint`` is its hint where there is no successor.
    """
    name = next(iter(unknown))
    raise UnknownArgumentError(function, name, _SUCCESSORS.get(name, hint))


class TruthError(UlnaError, ValueError):
    """The truth value of a result of several, which is ambiguous. ``use`` names the array of their truth values."""

    def __init__(self, result: str, use: str) -> None:
        super().__init__(f"the truth value of {result} of a batch is ambiguous; use {use}.any() or {use}.all()")
        self.result, self.use = result, use

    def __reduce__(self):
        return type(self), (self.result, self.use)


class UnknownNameError(UlnaError, LookupError):
    """An unknown name. ``name`` is what was asked for, ``known`` the names there are."""

    def __init__(self, kind: str, name: str, known: Iterable[str], hint: str = "") -> None:
        self.kind, self.name, self.known, self.hint = kind, name, tuple(known), hint
        super().__init__(f"no {kind} is called {name!r}{did_you_mean(name, self.known)}{hint}")

    def __reduce__(self):
        return type(self), (self.kind, self.name, self.known, self.hint)


class FileError(UlnaError, OSError):
    """A file that cannot be read or written. ``path`` names it."""

    def __init__(self, path: str, message: str) -> None:
        message = _shortened(message)
        super().__init__(f"{path}: {message}")
        self.path, self.message = path, message

    def __reduce__(self):
        return type(self), (self.path, self.message)


def reason_of(error: Exception, *, missing: str = "no such file") -> str:
    """Why a file cannot be read or written, in one wording for all files; ``missing`` is said where it is not there."""
    if isinstance(error, FileNotFoundError):
        return f"{missing}{twin_in_words(error.filename)}"
    return getattr(error, "strerror", None) or str(error)


def twin_in_words(path: object) -> str:
    """Names the file that differs from a missing one in upper and lower case only, to end a sentence."""
    twin = case_twin(Path(path)) if isinstance(path, (str, Path)) else None
    return "" if twin is None else f"; only upper and lower case differ from {twin}"


def case_twin(path: Path) -> Path | None:
    """A file that differs from a missing one in upper and lower case only, in its folder or in the folder's name."""
    for folder in dict.fromkeys((path.parent, path.parent.parent)):
        try:
            with os.scandir(folder) as entries:
                names = [entry.name for entry in islice(entries, _MAX_NAMES)]
        except (OSError, ValueError):
            continue
        below = path.relative_to(folder)
        for name in (one for one in names if one.casefold() == below.parts[0].casefold()):
            twin = folder.joinpath(name, *below.parts[1:])
            if twin.is_file():
                return twin
    return None


class MissingExtraError(UlnaError, ImportError):
    """Something that needs an extra of Ulna's which is not installed. ``extra`` names it; the message says how to install it."""

    def __init__(self, what: str, extra: str) -> None:
        super().__init__(f"{what} needs the {extra} extra: {install_command(extra)}")
        self.what, self.extra = what, extra

    def __reduce__(self):
        return type(self), (self.what, self.extra)


def install_command(extra: str, package: Path = _PACKAGE) -> str:
    """The command that adds an extra to this very copy: of its folder, of its wheel, or else of the packages by their names.

    No package index has Ulna. A message that named ``ulna[...]`` would install what anybody had registered under that name.
    """
    if package.parent.name == "src" and _is_project(package.parents[1]):  # a clone, installed or on the path
        folder = package.parents[1]
        return f'pip install -e "{"." if folder == _working_folder() else folder}[{extra}]"'
    from importlib.metadata import distributions  # noqa: PLC0415 - needed only where something is missing

    for copy in distributions(name="ulna", path=[str(package.parent)]):
        source = _installed_from(copy.read_text("direct_url.json") or "{}")
        if source is not None:
            return f'pip install "{source}[{extra}]"'
        needs = [need.partition(";") for need in copy.requires or ()]
        own = [f'"{need.strip()}"' for need, _, marker in needs if re.search(rf"extra == ['\"]{extra}['\"]", marker)]
        if own:
            return f"pip install {' '.join(own)}"
    return "install it as this copy was installed"


def _working_folder() -> Path | None:
    try:
        return Path.cwd()
    except OSError:  # it was deleted
        return None


def _is_project(folder: Path) -> bool:
    """Whether a folder holds the project, so that pip can install it."""
    file = folder / "pyproject.toml"
    return file.is_file() and 'name = "ulna"' in file.read_text(encoding="utf-8", errors="replace")


def _installed_from(direct_url: str) -> Path | None:
    """The wheel or the folder that pip installed (PEP 610), if it is still there."""
    from urllib.parse import urlsplit  # noqa: PLC0415 - as above
    from urllib.request import url2pathname  # noqa: PLC0415

    url = urlsplit(json.loads(direct_url).get("url", ""))
    if url.scheme != "file":
        return None
    source = Path(url2pathname(url.path))
    return source if (source.suffix == ".whl" and source.is_file()) or _is_project(source) else None


class MissingROSError(UlnaError, ImportError):
    """A part of ROS is not installed, or this Python does not find it."""


@contextmanager
def needs_extra(what: str, extra: str, *packages: str) -> Iterator[None]:
    """A context for imports of these packages, whose error says which extra to install.

    Raises:
        MissingExtraError: One of the packages is not installed.
    """
    try:
        yield
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in packages:
            raise
        raise MissingExtraError(what, extra) from None


class ClusterError(UlnaError, RuntimeError):
    """A cluster that cannot be reached any more, or whose workers die. What was computed until then is kept."""


class DeviceError(UlnaError, RuntimeError):
    """A GPU is needed, but none was found, or the one found cannot be used."""


class ArmError(UlnaError, RuntimeError):
    """An arm that has stopped by itself, or that refuses to move.

    Attributes:
        words: What its controller says.
        q: Where the arm was measured last [rad or m], a tuple of n_dof numbers; empty if it was not.
        record: What was commanded and measured until then, an ``ulna.arms.Record``, or None.
    """

    def __init__(self, message: str, words: str = "", q: Iterable[float] = (), record: Any = None) -> None:
        self.message, self.words, self.q, self.record = message, words, tuple(map(float, q)), record
        place = f"; it was last measured at q = ({', '.join(f'{each:.4f}' for each in self.q)})" if self.q else ""
        super().__init__(f"{message}{f': {words}' if words else ''}{place}")

    def __reduce__(self):
        return type(self), (self.message, self.words, self.q, self.record)


class ArmConnectionError(ArmError):
    """The connection to an arm that cannot be made, or was lost. Its controller stops the arm by itself then."""


class GeometryError(UlnaError, ValueError):
    """A collision query that is not possible with this robot's geometry."""


class InertiaError(UlnaError, ValueError):
    """A link that moves has no inertia, so no torque can be computed. ``links`` names all of them."""

    def __init__(self, message: str, links: Iterable[str] = ()) -> None:
        super().__init__(message)
        self.links = tuple(links)

    def __reduce__(self):
        return InertiaError, (str(self), self.links)


class SingularityError(UlnaError, ValueError):
    """A quantity that is not defined here. ``rows`` are the indices of the batch at which it is not."""

    def __init__(self, message: str, rows: tuple = ()) -> None:
        super().__init__(message)
        self.message, self.rows = message, rows

    def __reduce__(self):
        return type(self), (self.message, self.rows)


def _shortened(message: str) -> str:
    """The message, in which no quoted text is longer than ``MAX_CITED`` and which ends soon."""
    if len(message) > MAX_CITED:
        message = _QUOTED.sub(lambda found: f"{found[0][: MAX_CITED - 60]} ... {found[0][-50:]}", message)
    return message if len(message) <= _LONGEST else f"{message[: _LONGEST - 200]} ... {message[-195:]}"


class _Citing(reprlib.Repr):
    """The standard library's short representations, of which none takes longer for a larger value."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxlist = self.maxtuple = self.maxarray = 10
        self.maxstring = self.maxother = MAX_CITED - 20

    def repr_int(self, x: int, level: int) -> str:
        return super().repr_int(x, level) if x.bit_length() < 10 * MAX_CITED else f"a whole number of {x.bit_length()} bits"

    def repr_bytes(self, x: bytes, level: int) -> str:  # noqa: ARG002 - as the others
        return repr(x[: self.maxstring])

    def repr_dict(self, x: dict, level: int) -> str:
        some = list(islice(x.items(), self.maxdict if level > 0 else 0))
        inner = [f"{self.repr1(key, level - 1)}: {self.repr1(value, level - 1)}" for key, value in some]
        return "{" + ", ".join([*inner, *["..."] * (len(x) > len(some))]) + "}"


_citing = _Citing()


def cited(value: object) -> str:
    """The value as a message cites it: what ``repr`` gives, but at most ``MAX_CITED`` characters, and never more work than that.

    Example:
        >>> cited([1.0, "two"]), len(cited("x" * 1000)) <= MAX_CITED
        ("[1.0, 'two']", True)
    """
    text = _citing.repr(value)
    return text if len(text) <= MAX_CITED else f"{text[: MAX_CITED - 3]}..."


def count_of(n: int, noun: str, plural: str = "") -> str:
    """A number of things, as in "1 joint" and "2 joints"; ``plural`` where it is not the noun with an s."""
    return f"{n} {noun if n == 1 else plural or f'{noun}s'}"


def listed(names: Sequence[str], most: int = 6) -> str:
    """The first of some names, and how many there are beyond them."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def near_names(name: str, known: Iterable[str], most: int) -> list[str]:
    """The known names nearest to a name, best first; none for a name too long to be one: comparing takes the square of that."""
    import difflib  # noqa: PLC0415 - needed only where something is wrong

    short = [one for one in known if len(one) <= _LONGEST_NAME]
    return difflib.get_close_matches(str(name), short[:_MAX_NAMES], n=most) if len(str(name)) <= _LONGEST_NAME else []


def did_you_mean(name: str, known: Iterable[str], most: int = 8) -> str:
    """The end of a sentence that suggests the nearest known name, or lists a few."""
    known = [k if len(k) <= _LONGEST_NAME else f"{k[:_LONGEST_NAME]}..." for k in map(str, known)]
    near = near_names(name, known, 1)
    if near:
        return f"; did you mean {near[0]!r}?"
    if not known:
        return "; there are none"
    if len(known) == 1:
        return f"; the only one is {known[0]!r}"
    return f"; there are {listed([repr(k) for k in known], most)}"

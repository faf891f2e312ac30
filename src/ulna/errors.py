"""Defines every error that Ulna raises: each is an ``UlnaError`` and a built-in error.

Messages name the place and the remedy; errors carry their data as attributes.
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
_LONGEST = 1000  # maximum characters of a message
MAX_CITED = 200  # maximum characters of a value cited in a message
_QUOTED = re.compile(rf"'[^']{{{MAX_CITED - 1},}}+'|\"[^\"]{{{MAX_CITED - 1},}}+\"")
_LONGEST_NAME, _MAX_NAMES = 100, 10_000  # limits of the search for similar names
# Former arguments of functions, and their replacements.
_SUCCESSORS = {
    "method": "the search uses Levenberg-Marquardt; lesson 3 (docs/lessons/3_inverse_kinematics.ipynb) has the textbook methods "
    "in NumPy, hw2/franka_robot.py the Jacobian transpose",
    "threads": "ulna.threads(n) sets the maximum number of threads, from now on or in a with block",
}


class UlnaError(Exception):
    """The base class of all errors of this library."""


class DescriptionError(UlnaError, ValueError):
    """A robot description is invalid. ``source`` is its name, ``line`` the line of the fault (or None)."""

    def __init__(self, message: str, source: str = "", line: int | None = None) -> None:
        message = _shortened(message)
        place = ":".join(str(part) for part in (source, line) if part not in ("", None))
        super().__init__(f"{place}: {message}" if place else message)
        self.message, self.source, self.line = message, source, line

    def __reduce__(self):
        return type(self), (self.message, self.source, self.line)


class DescriptionWarning(UserWarning):
    """Parts of a description are ignored, such as references to unknown links or elements that Ulna does not support."""


class UnitWarning(UserWarning):
    """Lengths or angles are probably not in meters and radians, but in millimeters or degrees."""


class CompilerWarning(UserWarning):
    """The installed Numba lacks parts that the engine uses; entries are compiled without them. ``missing`` names them."""

    def __init__(self, message: str, missing: Iterable[str] = ()) -> None:
        super().__init__(message)
        self.missing = tuple(missing)


class InputError(UlnaError, ValueError):
    """An argument is invalid: a number, an array or an option. ``argument`` names it."""

    def __init__(self, argument: str, message: str) -> None:
        message = _shortened(message)
        super().__init__(f"{argument}: {message}")
        self.argument, self.message = argument, message

    def __reduce__(self):
        return type(self), (self.argument, self.message)


class UnknownArgumentError(UlnaError, TypeError):
    """A function has no such keyword argument. ``argument`` and ``function`` are the names of the two."""

    def __init__(self, function: str, argument: str, hint: str = "") -> None:
        super().__init__(f"{function}() got an unexpected keyword argument {argument!r}{hint and f'; {hint}'}")
        self.function, self.argument, self.hint = function, argument, hint

    def __reduce__(self):
        return type(self), (self.function, self.argument, self.hint)


def refuse_unknown(function: str, unknown: Iterable[str], hint: str = "") -> NoReturn:
    """Raise the error for the first of some unknown keyword arguments, with a hint.

    Raises:
        UnknownArgumentError: Always. For a former argument the hint names its replacement, else it is ``hint``.
    """
    name = next(iter(unknown))
    raise UnknownArgumentError(function, name, _SUCCESSORS.get(name, hint))


class TruthError(UlnaError, ValueError):
    """The truth value of a batch result is ambiguous. ``use`` names the array of truth values to use instead."""

    def __init__(self, result: str, use: str) -> None:
        super().__init__(f"the truth value of {result} of a batch is ambiguous; use {use}.any() or {use}.all()")
        self.result, self.use = result, use

    def __reduce__(self):
        return type(self), (self.result, self.use)


class UnknownNameError(UlnaError, LookupError):
    """A name is unknown. ``name`` is the given name, ``known`` lists the valid names."""

    def __init__(self, kind: str, name: str, known: Iterable[str], hint: str = "") -> None:
        self.kind, self.name, self.known, self.hint = kind, name, tuple(known), hint
        super().__init__(f"no {kind} is called {name!r}{did_you_mean(name, self.known)}{hint}")

    def __reduce__(self):
        return type(self), (self.kind, self.name, self.known, self.hint)


class FileError(UlnaError, OSError):
    """A file cannot be read or written. ``path`` names it."""

    def __init__(self, path: str, message: str) -> None:
        message = _shortened(message)
        super().__init__(f"{path}: {message}")
        self.path, self.message = path, message

    def __reduce__(self):
        return type(self), (self.path, self.message)


def reason_of(error: Exception, *, missing: str = "no such file") -> str:
    """The reason why a file cannot be read or written; ``missing`` is the text for a missing file."""
    if isinstance(error, FileNotFoundError):
        return f"{missing}{twin_in_words(error.filename)}"
    return getattr(error, "strerror", None) or str(error)


def twin_in_words(path: object) -> str:
    """The end of a message that names the ``case_twin`` of a missing file; empty without a twin."""
    twin = case_twin(Path(path)) if isinstance(path, (str, Path)) else None
    return "" if twin is None else f"; only upper and lower case differ from {twin}"


def case_twin(path: Path) -> Path | None:
    """A file whose path differs from a missing file's in case only, in its name or its folder's name."""
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
    """An extra of Ulna is not installed. ``extra`` names it; the message contains the command that installs it."""

    def __init__(self, what: str, extra: str) -> None:
        super().__init__(f"{what} needs the {extra} extra: {install_command(extra)}")
        self.what, self.extra = what, extra

    def __reduce__(self):
        return type(self), (self.what, self.extra)


def install_command(extra: str, package: Path = _PACKAGE) -> str:
    """The pip command that adds an extra to this copy of Ulna.

    It names the copy's folder or wheel, or else the packages of the extra. No package index has Ulna. A command with
    ``ulna[...]`` would install whatever somebody registers under that name.
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
    except OSError:  # the folder was deleted
        return None


def _is_project(folder: Path) -> bool:
    """Whether a folder contains the project, so that pip can install it."""
    file = folder / "pyproject.toml"
    return file.is_file() and 'name = "ulna"' in file.read_text(encoding="utf-8", errors="replace")


def _installed_from(direct_url: str) -> Path | None:
    """The wheel or the folder that pip installed (PEP 610), if it still exists."""
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
    """A context for imports of these packages: a failed import raises an error that names the extra.

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
    """A cluster is no longer reachable, or its workers die. Results computed before that are kept."""


class DeviceError(UlnaError, RuntimeError):
    """A GPU is needed, but none was found, or it cannot be used."""


class ArmError(UlnaError, RuntimeError):
    """An arm stopped by itself, or refuses to move.

    Attributes:
        words: The message of its controller.
        q: The last measured configuration [rad or m], a tuple of n_dof numbers; empty without a measurement.
        record: The commands and measurements until then, an ``ulna.arms.Record``, or None.
    """

    def __init__(self, message: str, words: str = "", q: Iterable[float] = (), record: Any = None) -> None:
        self.message, self.words, self.q, self.record = message, words, tuple(map(float, q)), record
        place = f"; it was last measured at q = ({', '.join(f'{each:.4f}' for each in self.q)})" if self.q else ""
        super().__init__(f"{message}{f': {words}' if words else ''}{place}")

    def __reduce__(self):
        return type(self), (self.message, self.words, self.q, self.record)


class ArmConnectionError(ArmError):
    """The connection to an arm cannot be made, or was lost. The arm's controller then stops the arm."""


class GeometryError(UlnaError, ValueError):
    """The geometry of the robot does not allow a collision query."""


class InertiaError(UlnaError, ValueError):
    """Moving links have no inertia, so no torque can be computed. ``links`` names all of them."""

    def __init__(self, message: str, links: Iterable[str] = ()) -> None:
        super().__init__(message)
        self.links = tuple(links)

    def __reduce__(self):
        return InertiaError, (str(self), self.links)


class SingularityError(UlnaError, ValueError):
    """A quantity is not defined at a singularity. ``rows`` lists the indices of the batch where."""

    def __init__(self, message: str, rows: tuple = ()) -> None:
        super().__init__(message)
        self.message, self.rows = message, rows

    def __reduce__(self):
        return type(self), (self.message, self.rows)


def _shortened(message: str) -> str:
    """Shorten a message: quoted texts to ``MAX_CITED`` characters, all of it to ``_LONGEST``."""
    if len(message) > MAX_CITED:
        message = _QUOTED.sub(lambda found: f"{found[0][: MAX_CITED - 60]} ... {found[0][-50:]}", message)
    return message if len(message) <= _LONGEST else f"{message[: _LONGEST - 200]} ... {message[-195:]}"


class _Citing(reprlib.Repr):
    """The standard library's short representations, in bounded time for values of any size."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxlist = self.maxtuple = self.maxarray = 10
        self.maxstring = self.maxother = MAX_CITED - 20

    def repr_int(self, x: int, level: int) -> str:
        return super().repr_int(x, level) if x.bit_length() < 10 * MAX_CITED else f"a whole number of {x.bit_length()} bits"

    def repr_bytes(self, x: bytes, level: int) -> str:  # noqa: ARG002 - same signature as the others
        return repr(x[: self.maxstring])

    def repr_dict(self, x: dict, level: int) -> str:
        some = list(islice(x.items(), self.maxdict if level > 0 else 0))
        inner = [f"{self.repr1(key, level - 1)}: {self.repr1(value, level - 1)}" for key, value in some]
        return "{" + ", ".join([*inner, *["..."] * (len(x) > len(some))]) + "}"


_citing = _Citing()


def cited(value: object) -> str:
    """The ``repr`` of a value for a message, with at most ``MAX_CITED`` characters, in bounded time.

    Example:
        >>> cited([1.0, "two"]), len(cited("x" * 1000)) <= MAX_CITED
        ("[1.0, 'two']", True)
    """
    text = _citing.repr(value)
    return text if len(text) <= MAX_CITED else f"{text[: MAX_CITED - 3]}..."


def count_of(n: int, noun: str, plural: str = "") -> str:
    """A number with its noun, as "1 joint" or "2 joints"; ``plural`` for irregular plurals."""
    return f"{n} {noun if n == 1 else plural or f'{noun}s'}"


def listed(names: Sequence[str], most: int = 6) -> str:
    """The first ``most`` names, and the number of further names."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def near_names(name: str, known: Iterable[str], most: int) -> list[str]:
    """The known names most similar to a name, best first.

    There are none for a very long name, since the comparison takes quadratic time.
    """
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

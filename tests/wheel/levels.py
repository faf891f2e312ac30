"""Prints the levels of the installed wheel that this CPU has, lowest first."""

import json

from ulna.engine import _calls
from ulna.engine.ahead import FOLDER, INDEX

if __name__ == "__main__":
    levels = json.loads((FOLDER / INDEX).read_text())["levels"]
    print(*[name for name, level in levels.items() if level["needs"] <= _calls.x86_level()], sep="\n")  # noqa: T201

"""What a wheel has and a clone has not: without the extension nothing here is collected. `make test-wheel` has it."""

from importlib.util import find_spec

collect_ignore_glob = [] if find_spec("ulna.engine._calls") else ["*.py"]

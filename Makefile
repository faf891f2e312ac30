# make demo: set up and run the demo.  make test: set up and pass the quick tests; make test-all: all of them.
# make bench: measure, with the peers beside Ulna.
# make docs: write the documentation site to build/docs, after running every lesson.
# All may be run again and again.
PYTHON ?= python3
VENV ?= .venv
RUN = $(VENV)/bin
AHEAD = 1
WHEEL_DIR = dist
LOWEST = tests
HIGHER = tests/kernels tests/wheel
BUT =
ARGS ?=

.PHONY: demo video lint test test-all test-lowest test-newest test-without-demo test-cuda test-gpu test-franka test-ros1 test-ros2 test-wheel test-wheel-brief
.PHONY: test-learning bench bench-gpu gpu docs wheel hw2-zip clean

demo: $(VENV)/.demo
	$(RUN)/ulna demo $(ARGS)

# The assignment's video, made with no display: hw2-zip packs it. ARGS="--seconds 60" makes another. ROS=1 records real RViz, with the box
# dragged by its arrows and a ring: where ROS 1, Xvfb and xdotool are there (docs/ros.md).
ifeq ($(ROS),1)
video: .venv-ros1/.ready
	.venv-ros1/bin/ulna ros1 record hw2/demo.mp4 $(ARGS)
else
video: $(VENV)/.demo
	$(RUN)/ulna record hw2/demo.mp4 $(ARGS)
endif

# Style, types, spelling, and the files of the repository's host against their schemas.
lint: $(VENV)/.dev
	$(RUN)/ruff check
	$(RUN)/ruff format --check
	$(RUN)/python tests/english.py
	$(RUN)/codespell README.md CONTRIBUTING.md docs src hw2 examples benchmarks native
	$(RUN)/pyright --threads 2 --pythonpath $(RUN)/python
	$(RUN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(RUN)/check-jsonschema --builtin-schema vendor.github-issue-forms .github/ISSUE_TEMPLATE/bug.yml .github/ISSUE_TEMPLATE/wish.yml
	$(RUN)/check-jsonschema --builtin-schema vendor.github-issue-config .github/ISSUE_TEMPLATE/config.yml
	$(RUN)/check-jsonschema --builtin-schema vendor.readthedocs .readthedocs.yaml
	$(RUN)/check-jsonschema --builtin-schema vendor.citation-file-format CITATION.cff

# A file of Python is compiled once, not by every worker and every interpreter that a test starts, whatever the environment says.
test test-all: export PYTHONDONTWRITEBYTECODE =

# Style, types, and the quick tests: without those marked slow, matrix or process (pyproject.toml says what these are). The kernels are
# compiled first, once, not by each process of the tests.
test: lint
	@echo "make test: five to nine minutes on two cores, and the first time 2 more, in which the kernels are compiled."
	$(RUN)/ulna warmup
	$(RUN)/python -m pytest -n auto -m "not slow and not matrix and not process" $(ARGS)

# All of them, as in CI; then the kernels again without the compiler, and for a plain CPU.
test-all: lint
	@echo "make test-all: about half an hour on two idle cores, and the first time 2 more, in which the kernels are compiled."
	$(RUN)/ulna warmup
	$(RUN)/python -m pytest -n auto $(ARGS)
	NUMBA_DISABLE_JIT=1 $(RUN)/python -m pytest -n auto tests/kernels
	NUMBA_CPU_NAME=generic $(RUN)/python -m pytest -n auto tests/kernels

# Every kernel and driver compiled for a GPU, to PTX; the drivers run by simulated threads. No GPU and no driver is needed.
test-cuda: .venv-cuda/.ready
	.venv-cuda/bin/python -m pytest -n auto tests/gpu --ignore=tests/gpu/device $(ARGS)
	NUMBA_ENABLE_CUDASIM=1 NUMBA_DISABLE_JIT=1 .venv-cuda/bin/python -m pytest -n auto tests/gpu/device --deselect \
		tests/gpu/device/test_gpu_robot.py::test_arrays_are_given_and_taken_by_dlpack

# The drivers on a GPU, against the CPU.
test-gpu: .venv-cuda/.ready
	.venv-cuda/bin/python -m pytest tests/gpu/device $(ARGS)

# Problems a second on a GPU. ARGS="--first edges,clouds --seconds 300" measures these parts first, and stops in time.
bench-gpu: .venv-cuda/.ready
	.venv-cuda/bin/python -m benchmarks.gpu $(ARGS)

# Both, and the peers that are installed, on a GPU that is there for eight minutes. ARGS="--first edges,clouds" measures first what has
# changed. The output is in build/gpu.
gpu: .venv-cuda/.ready
	.venv-cuda/bin/python -m benchmarks.gpu_session $(ARGS)

# Poses, Jacobians and distances of PyTorch's and JAX's arrays, with their gradients, on the CPU; on a GPU too where PyTorch finds one.
test-learning: .venv-learning/.ready
	.venv-learning/bin/python -m pytest tests/learning $(ARGS)

# The tests of the core, of descriptions, plans and maps, where every direct dependency has the lowest version that pyproject.toml allows.
# The highest are what any new environment gets. pip cannot choose the lowest; uv can.
test-lowest: .venv-lowest/.ready
	.venv-lowest/bin/python -m pytest -n auto -m "not slow" tests/engine tests/kinematics tests/collision tests/ik tests/cli \
	    tests/description tests/inspection tests/planning tests/reachability $(ARGS)

# The tests of the core, of descriptions and meshes, with the newest of everything: of Python 3.13 unless NEWEST names another, and of each
# package. Elsewhere NumPy is held back by an older Python.
NEWEST_TESTS = tests/engine tests/kinematics tests/collision tests/ik tests/description tests/inspection tests/planning
NEWEST ?= $(or $(shell PYENV_VERSION=3.13.0 pyenv which python3.13 2>/dev/null),python3.13)
test-newest:
	@$(NEWEST) --version >/dev/null 2>&1 || { echo "make test-newest: no $(NEWEST); install Python 3.13 (pyenv install 3.13.0, or from \
	python.org), or name another: make test-newest NEWEST=python3.14" >&2; exit 1; }
	$(MAKE) .venv-newest/.ready
	.venv-newest/bin/python -m pytest -n auto -m "not slow and not matrix and not process" $(NEWEST_TESTS) $(ARGS)

# All tests of the library in a copy without the demo, hw2 and their tests: the demo is a guest.
test-without-demo: $(VENV)/.dev
	$(RUN)/python tests/without_demo.py -n auto $(ARGS)

# The peers, side by side with Ulna: writes benchmarks/results/. ARGS="--robot panda --n 10000" asks for less or more. WHEEL=1 measures
# the wheel with machine code, instead of code that is compiled here.
ifeq ($(WHEEL),1)
bench: wheel .venv-bench/.ready
	.venv-bench/bin/python -m pip install --quiet --force-reinstall --no-deps "$$(ls -t $(WHEEL_DIR)/ulna-*-abi3-*.whl | head -1)"
	.venv-bench/bin/python -m benchmarks $(ARGS)
else
bench: .venv-bench/.ready
	.venv-bench/bin/python -m pip install --quiet --no-deps --editable .
	.venv-bench/bin/python -m benchmarks $(ARGS)
endif

# The documentation site. A warning is a failure: a public name without documentation, a link that leads nowhere, a lesson that fails.
# Nothing is fetched while it is written (there is no network then), nor when it is read.
docs: .venv-docs/.ready
	rm -rf build/docs
	.ci/offline .venv-docs/bin/python -m sphinx --quiet --fail-on-warning --keep-going --fresh-env -d build/docs-read -b html docs build/docs $(ARGS)
	@echo "build/docs/index.html"

# The driver of a Franka against two simulators of its controller (docs/franka.md), on loopback, in processes of their own.
test-franka: .venv-franka/.ready .venv-franky/.ready
	FRANKY_PYTHON=.venv-franky/bin/python .venv-franka/bin/python -m pytest -rP tests/franka $(ARGS)

# The demo in ROS, with the real parts, each ROS in an environment of its own. Without ROS 1 its tests are skipped and say so.
test-ros1: .venv-ros1/.ready
	.ci/offline .venv-ros1/bin/python -m pytest tests/demo/ros/ros1 $(ARGS)

test-ros2: .venv-ros2/.ready
	.ci/offline .venv-ros2/bin/python -m pytest tests/demo/ros/ros2 $(ARGS)

# A wheel with the machine code of every entry, in dist/: what it is installed for needs no compiler (docs/ahead.md). Building it needs a
# C compiler, and takes three to five minutes on two cores; what has not changed since is not compiled again.
wheel:
	ULNA_AHEAD=$(AHEAD) $(PYTHON) -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir $(WHEEL_DIR) .

# The tests with the wheel, in an environment without Numba: all at the lowest level of CPU but those about the compiler, then at each
# level that this CPU has the bits of every entry beside those of code that is compiled now, in another order and another process, and
# the tests of the kernels.
test-wheel: wheel $(VENV)/.dev
	rm -rf .venv-wheel build/bits build/now && mkdir -p build/bits
	$(MAKE) .venv-wheel/.ready
	! .venv-wheel/bin/python -c "import numba" 2>/dev/null
	for level in $$(.venv-wheel/bin/python tests/wheel/levels.py); do \
	    export NUMBA_CACHE_DIR=$$PWD/build/now NUMBA_CPU_NAME=$$level NUMBA_CPU_FEATURES= PYTHONHASHSEED=0; \
	    $(RUN)/ulna warmup && $(RUN)/python tests/wheel/every_entry.py build/bits/$$level.json || exit 1; \
	done
	ULNA_CPU=$$(.venv-wheel/bin/python tests/wheel/levels.py | head -1) ULNA_BITS=$$PWD/build/bits \
	    .venv-wheel/bin/python -m pytest -n auto -m "not compiler $(BUT)" $(LOWEST) $(ARGS)
	for level in $$(.venv-wheel/bin/python tests/wheel/levels.py | tail -n +2); do \
	    ULNA_CPU=$$level ULNA_BITS=$$PWD/build/bits .venv-wheel/bin/python -m pytest -n auto -m "not compiler $(BUT)" $(HIGHER) || exit 1; \
	done

# The same in less time, as CI does it: a wheel for the lowest level alone, and of the tests, without the slow ones, those of the folders
# where machine code is called. Of tests/kernels most run formulas, which are Python here: test-all does that with NUMBA_DISABLE_JIT.
test-wheel-brief:
	$(MAKE) test-wheel AHEAD=lowest WHEEL_DIR=build/dist BUT="and not slow" LOWEST="tests/wheel tests/test_types.py tests/engine tests/kinematics tests/robot \
	    tests/ik tests/collision $$(grep -l 'from ulna.[a-z.]*entries import' tests/kernels/*.py | tr '\n' ' ')"

# The assignment's submission, hw2.zip: its files, the wheel of ulna that they need, and a video if one lies there (hw2/*.mp4).
hw2-zip:
	rm -rf build/hw2 && mkdir -p build/hw2
	cp -L $(wildcard hw2/*.*) docs/ros.md build/hw2
	$(PYTHON) -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir build/hw2 .
	rm -f hw2.zip && $(PYTHON) -m zipfile -c hw2.zip build/hw2
	@test -f hw2/demo.mp4 || echo "hw2.zip has no video: make video, then make hw2-zip again" >&2
	@echo "hw2.zip: unzip it, then pip install -r hw2/requirements.txt"

# The environment to work in: what the demo and a video need, with the Panda's own shells, and all for the tests. The shells are 4.3 MB of a
# package that asks for a simulator and an older Python, neither of which they need; without them the arm is drawn from its joints. Entry
# points, by which the demo adds its commands, count once the package is installed again: pyproject.toml is newer then.
$(VENV)/.demo $(VENV)/.dev: pyproject.toml | $(RUN)/python
	$(RUN)/python -m pip install --quiet --disable-pip-version-check --upgrade 'pip>=25.1'
	$(RUN)/python -m pip install --quiet --disable-pip-version-check --editable $(INSTALLED)
	-$(RUN)/python -m pip install --quiet --disable-pip-version-check --no-deps --ignore-requires-python dm-robotics-panda==0.4.8
	touch $(READY)
$(VENV)/.demo: INSTALLED = '.[viewer]'
$(VENV)/.demo: READY = $(VENV)/.demo
$(VENV)/.dev: INSTALLED = '.[viewer,meshes]' --group dev
$(VENV)/.dev: READY = $(VENV)/.demo $(VENV)/.dev

$(RUN)/python:
	$(PYTHON) -m venv $(VENV)

# Every other environment is .venv-GROUP, made for a dependency group of pyproject.toml, by this one recipe: `make .venv-docs/.ready`. Each
# is apart because its packages are large, hold back the versions of others, or are of a system. Below is what one of them needs besides.
.venv-%/.ready: pyproject.toml
	$(PYTHON) -m venv $(VENV_OPTIONS) $(@D)
	$(@D)/bin/python -m pip install --quiet --upgrade 'pip>=25.1'
	$(BEFORE)
	$(@D)/bin/python -m pip install --quiet $(INSTALLED) --group $(GROUP) $(OTHERWISE)
	touch $@

VENV_OPTIONS =
BEFORE =
INSTALLED = --editable .
GROUP = $*
OTHERWISE =
.venv-docs/.ready: INSTALLED = --editable '.[viewer]'
.venv-franky/.ready: INSTALLED =
# A peer that cannot be installed is named, and the rest is measured without it.
.venv-bench/.ready: BEFORE = $(@D)/bin/python -m pip install --quiet --editable .
.venv-bench/.ready: INSTALLED = --only-binary :all:
.venv-bench/.ready: OTHERWISE = || $(@D)/bin/python -m benchmarks.install
# pip cannot choose the lowest versions; uv can, in an empty environment, if what the tests need is chosen with the rest.
.venv-lowest/.ready: VENV_OPTIONS = --clear
.venv-lowest/.ready: BEFORE = $(@D)/bin/python -m pip install --quiet uv && \
	$(@D)/bin/uv pip install --quiet --python $(@D)/bin/python --resolution lowest-direct --editable '.[viewer]' --group core
.venv-lowest/.ready: INSTALLED = --editable '.[viewer]'
.venv-lowest/.ready: GROUP = core
.venv-newest/.ready: PYTHON = $(NEWEST)
.venv-newest/.ready: VENV_OPTIONS = --clear
.venv-newest/.ready: INSTALLED = --upgrade --upgrade-strategy eager --editable '.[viewer]'
.venv-newest/.ready: GROUP = newest
.venv-wheel/.ready: INSTALLED = "$$(ls -t $(WHEEL_DIR)/ulna-*-abi3-*.whl | head -1)[viewer,meshes]"
.venv-wheel/.ready: GROUP = tests
# Debian's own Python, which sees Debian's rospy; what is in the environment comes first.
.venv-ros1/.ready: PYTHON = /usr/bin/python3
.venv-ros1/.ready: VENV_OPTIONS = --system-site-packages
.venv-ros1/.ready: INSTALLED = --editable '.[viewer,meshes]'
.venv-ros1/.ready: GROUP = ros

clean:
	rm -rf $(VENV) .venv-* hw2.zip .pytest_cache .ruff_cache .hypothesis .import_linter_cache build

# make demo: set up and run the demo.  make test: set up and pass the tests; make test-all: the slow ones too.
# make bench: measure, with the peers beside Ulna.
# make docs: write the documentation site to build/docs, after running every lesson.
# All may be run again and again.
PYTHON ?= python3
VENV ?= .venv
RUN = $(VENV)/bin
BENCH_VENV ?= .venv-bench
DOCS_VENV ?= .venv-docs
CUDA_VENV ?= .venv-cuda
WHEEL_VENV ?= .venv-wheel
LOWEST_VENV ?= .venv-lowest
FRANKA_VENV ?= .venv-franka
FRANKY_VENV ?= .venv-franky
AHEAD = 1
WHEEL_DIR = dist
LOWEST = tests
HIGHER = tests/kernels tests/wheel
BUT =
ARGS ?=

.PHONY: demo video lint test test-all test-lowest test-without-demo test-cuda test-gpu test-franka test-ros1 test-ros2 test-wheel test-wheel-brief
.PHONY: bench bench-gpu docs wheel hw2-zip clean

demo: $(VENV)/.demo
	$(RUN)/ulna demo $(ARGS)

# The assignment's video, made with no display: hw2-zip packs it. ARGS="--seconds 60" makes another. ROS=1 records real RViz, with the box
# dragged by its arrows: where ROS 1, Xvfb and xdotool are there (docs/ros.md).
ifeq ($(ROS),1)
video: .venv-ros1/.ready
	.venv-ros1/bin/ulna ros1 record hw2/demo.mp4 $(ARGS)
else
video: $(VENV)/.video
	$(RUN)/ulna record hw2/demo.mp4 $(ARGS)
endif

# Style, types, and the files of the repository's host against their schemas.
lint: $(VENV)/.dev
	$(RUN)/ruff check
	$(RUN)/ruff format --check
	$(RUN)/pyright --pythonpath $(RUN)/python
	$(RUN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(RUN)/check-jsonschema --builtin-schema vendor.github-issue-forms .github/ISSUE_TEMPLATE/bug.yml .github/ISSUE_TEMPLATE/wish.yml
	$(RUN)/check-jsonschema --builtin-schema vendor.github-issue-config .github/ISSUE_TEMPLATE/config.yml
	$(RUN)/check-jsonschema --builtin-schema vendor.readthedocs .readthedocs.yaml
	$(RUN)/check-jsonschema --builtin-schema vendor.citation-file-format CITATION.cff

# Style, types, and the tests but those marked slow. The kernels are compiled first, once, not by each process of the tests.
test: lint
	@echo "make test: about 8 minutes on two idle cores, and the first time 2 more, in which the kernels are compiled."
	$(RUN)/ulna warmup
	$(RUN)/python -m pytest -n auto -m "not slow" $(ARGS)

# All of them, as in CI; then the kernels again without the compiler, and for a plain CPU.
test-all: lint
	@echo "make test-all: about 15 minutes on two idle cores, and the first time 2 more, in which the kernels are compiled."
	$(RUN)/ulna warmup
	$(RUN)/python -m pytest -n auto $(ARGS)
	NUMBA_DISABLE_JIT=1 $(RUN)/python -m pytest -n auto tests/kernels
	NUMBA_CPU_NAME=generic $(RUN)/python -m pytest -n auto tests/kernels

# Every kernel and driver compiled for a GPU, to PTX; the drivers run by simulated threads. No GPU and no driver is needed.
test-cuda: $(CUDA_VENV)/.cuda
	$(CUDA_VENV)/bin/python -m pytest -n auto tests/gpu --ignore=tests/gpu/device $(ARGS)
	NUMBA_ENABLE_CUDASIM=1 NUMBA_DISABLE_JIT=1 $(CUDA_VENV)/bin/python -m pytest -n auto tests/gpu/device --deselect \
		tests/gpu/device/test_gpu_robot.py::test_arrays_are_given_and_taken_by_dlpack

# The drivers on a GPU, against the CPU.
test-gpu: $(CUDA_VENV)/.cuda
	$(CUDA_VENV)/bin/python -m pytest tests/gpu/device $(ARGS)

# Problems a second on a GPU.
bench-gpu: $(CUDA_VENV)/.cuda
	$(CUDA_VENV)/bin/python -m benchmarks.gpu $(ARGS)

# An environment of its own: the compiler's wheels are large, and nothing else needs them.
$(CUDA_VENV)/.cuda: pyproject.toml
	$(PYTHON) -m venv $(CUDA_VENV)
	$(CUDA_VENV)/bin/python -m pip install --quiet --upgrade 'pip>=25.1'
	$(CUDA_VENV)/bin/python -m pip install --quiet --editable . --group cuda
	touch $@

# The tests of the core, where every direct dependency has the lowest version that pyproject.toml allows. The highest are what any new
# environment gets. pip cannot choose the lowest; uv can.
test-lowest: $(LOWEST_VENV)/.lowest
	$(LOWEST_VENV)/bin/python -m pytest -n auto -m "not slow" tests/engine tests/kinematics tests/collision tests/ik tests/cli $(ARGS)

$(LOWEST_VENV)/.lowest: pyproject.toml
	rm -rf $(LOWEST_VENV)
	$(PYTHON) -m venv $(LOWEST_VENV)
	$(LOWEST_VENV)/bin/python -m pip install --quiet uv
	$(LOWEST_VENV)/bin/uv pip install --quiet --python $(LOWEST_VENV)/bin/python --resolution lowest-direct --editable '.[viewer]'
	$(LOWEST_VENV)/bin/uv pip install --quiet --python $(LOWEST_VENV)/bin/python --editable '.[viewer]' --group tests
	touch $@

# All tests of the library in a copy without the demo, hw2 and their tests: the demo is a guest.
test-without-demo: $(VENV)/.dev
	$(RUN)/python tests/without_demo.py -n auto $(ARGS)

# The peers, side by side with Ulna: writes benchmarks/results/. ARGS="--robot panda --n 10000" asks for less or more. WHEEL=1 measures
# the wheel with machine code, instead of code that is compiled here.
ifeq ($(WHEEL),1)
bench: wheel $(BENCH_VENV)/.bench
	$(BENCH_VENV)/bin/python -m pip install --quiet --force-reinstall --no-deps "$$(ls -t $(WHEEL_DIR)/ulna-*-abi3-*.whl | head -1)"
	$(BENCH_VENV)/bin/python -m benchmarks $(ARGS)
else
bench: $(BENCH_VENV)/.bench
	$(BENCH_VENV)/bin/python -m pip install --quiet --no-deps --editable .
	$(BENCH_VENV)/bin/python -m benchmarks $(ARGS)
endif

# An environment of its own: some peers hold back the versions of packages that the tests use. One that cannot be installed is
# named, and the rest is measured without it.
$(BENCH_VENV)/.bench: pyproject.toml
	$(PYTHON) -m venv $(BENCH_VENV)
	$(BENCH_VENV)/bin/python -m pip install --quiet --upgrade 'pip>=25.1'
	$(BENCH_VENV)/bin/python -m pip install --quiet --editable .
	$(BENCH_VENV)/bin/python -m pip install --quiet --only-binary :all: --group bench || $(BENCH_VENV)/bin/python -m benchmarks.install
	touch $@

# The documentation site. A warning is a failure: a public name without documentation, a link that leads nowhere, a lesson that fails.
# Nothing is fetched while it is written (there is no network then), nor when it is read.
docs: $(DOCS_VENV)/.docs
	rm -rf build/docs
	.ci/offline $(DOCS_VENV)/bin/python -m sphinx --quiet --fail-on-warning --keep-going --fresh-env -d build/docs-read -b html docs build/docs $(ARGS)
	@echo "build/docs/index.html"

$(DOCS_VENV)/.docs: pyproject.toml
	$(PYTHON) -m venv $(DOCS_VENV)
	$(DOCS_VENV)/bin/python -m pip install --quiet --upgrade 'pip>=25.1'
	$(DOCS_VENV)/bin/python -m pip install --quiet --editable '.[viewer]' --group docs
	touch $@

# The driver of a Franka against two simulators of its controller (docs/franka.md), on loopback, in processes of their own.
test-franka: $(FRANKA_VENV)/.franka
	FRANKY_PYTHON=$(FRANKY_VENV)/bin/python $(FRANKA_VENV)/bin/python -m pytest -rP tests/franka $(ARGS)

$(FRANKA_VENV)/.franka: pyproject.toml
	$(PYTHON) -m venv $(FRANKA_VENV)
	$(FRANKA_VENV)/bin/python -m pip install --quiet --upgrade 'pip>=25.1'
	$(FRANKA_VENV)/bin/python -m pip install --quiet --editable . --group franka
	$(PYTHON) -m venv $(FRANKY_VENV)
	$(FRANKY_VENV)/bin/python -m pip install --quiet --upgrade 'pip>=25.1'
	$(FRANKY_VENV)/bin/python -m pip install --quiet --group franky
	touch $@

# The demo in ROS, with the real parts, each ROS in an environment of its own. Without ROS 1 its tests are skipped and say so.
test-ros1: .venv-ros1/.ready
	.ci/offline .venv-ros1/bin/python -m pytest tests/demo/ros/ros1 $(ARGS)

test-ros2: .venv-ros2/.ready
	.ci/offline .venv-ros2/bin/python -m pytest tests/demo/ros/ros2 $(ARGS)

# Debian's own Python, which sees Debian's rospy; what is in the environment comes first.
.venv-ros1/.ready: pyproject.toml
	/usr/bin/python3 -m venv --system-site-packages .venv-ros1
	.venv-ros1/bin/python -m pip install --quiet --upgrade 'pip>=25.1'
	.venv-ros1/bin/python -m pip install --quiet --editable '.[viewer,meshes]' --group ros
	touch $@

.venv-ros2/.ready: pyproject.toml
	$(PYTHON) -m venv .venv-ros2
	.venv-ros2/bin/python -m pip install --quiet --upgrade 'pip>=25.1'
	.venv-ros2/bin/python -m pip install --quiet --editable . --group ros2
	touch $@

# A wheel with the machine code of every entry, in dist/: what it is installed for needs no compiler (docs/ahead.md). Building it needs a
# C compiler, and takes three to five minutes on two cores; what has not changed since is not compiled again.
wheel:
	ULNA_AHEAD=$(AHEAD) $(PYTHON) -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir $(WHEEL_DIR) .

# The tests with the wheel, in an environment without Numba: all at the lowest level of CPU but those about the compiler, then at each
# level that this CPU has the bits of every entry beside those of code that is compiled now, in another order and another process, and
# the tests of the kernels.
test-wheel: wheel $(VENV)/.dev
	rm -rf $(WHEEL_VENV) build/bits build/now && mkdir -p build/bits
	$(PYTHON) -m venv $(WHEEL_VENV)
	$(WHEEL_VENV)/bin/python -m pip install --quiet --upgrade 'pip>=25.1'
	$(WHEEL_VENV)/bin/python -m pip install --quiet "$$(ls -t $(WHEEL_DIR)/ulna-*-abi3-*.whl | head -1)[viewer,meshes]" --group tests
	! $(WHEEL_VENV)/bin/python -c "import numba" 2>/dev/null
	for level in $$($(WHEEL_VENV)/bin/python tests/wheel/levels.py); do \
	    export NUMBA_CACHE_DIR=$$PWD/build/now NUMBA_CPU_NAME=$$level NUMBA_CPU_FEATURES= PYTHONHASHSEED=0; \
	    $(RUN)/ulna warmup && $(RUN)/python tests/wheel/every_entry.py build/bits/$$level.json || exit 1; \
	done
	ULNA_CPU=$$($(WHEEL_VENV)/bin/python tests/wheel/levels.py | head -1) ULNA_BITS=$$PWD/build/bits \
	    $(WHEEL_VENV)/bin/python -m pytest -n auto -m "not compiler $(BUT)" $(LOWEST) $(ARGS)
	for level in $$($(WHEEL_VENV)/bin/python tests/wheel/levels.py | tail -n +2); do \
	    ULNA_CPU=$$level ULNA_BITS=$$PWD/build/bits $(WHEEL_VENV)/bin/python -m pytest -n auto -m "not compiler $(BUT)" $(HIGHER) || exit 1; \
	done

# The same in less time, as CI does it: a wheel for the lowest level alone, and of the tests, without the slow ones, those of the folders
# where machine code is called. Of tests/kernels most run formulas, which are Python here: test-all does that with NUMBA_DISABLE_JIT.
test-wheel-brief:
	$(MAKE) test-wheel AHEAD=lowest WHEEL_DIR=build/dist BUT="and not slow" LOWEST="tests/wheel tests/engine tests/kinematics tests/robot \
	    tests/ik tests/collision $$(grep -l 'from ulna.drivers import' tests/kernels/*.py | tr '\n' ' ')"

# The assignment's submission, hw2.zip: its files, the wheel of ulna that they need, and a video if one lies there (hw2/*.mp4).
hw2-zip:
	rm -rf build/hw2 && mkdir -p build/hw2
	cp -L $(wildcard hw2/*.*) docs/ros.md build/hw2
	$(PYTHON) -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir build/hw2 .
	rm -f hw2.zip && $(PYTHON) -m zipfile -c hw2.zip build/hw2
	@test -f hw2/demo.mp4 || echo "hw2.zip has no video: make video, then make hw2-zip again" >&2
	@echo "hw2.zip: unzip it, then pip install -r hw2/requirements.txt"

$(RUN)/python:
	$(PYTHON) -m venv $(VENV)

# Entry points, by which the demo adds its commands, count once the package is installed again: pyproject.toml is newer then.
$(VENV)/.demo: pyproject.toml | $(RUN)/python
	$(RUN)/python -m pip install --quiet --disable-pip-version-check --editable '.[viewer]'
	touch $@

# With the meshes: the film shows a Franka, not tubes.
$(VENV)/.video: pyproject.toml | $(RUN)/python
	$(RUN)/python -m pip install --quiet --disable-pip-version-check --editable '.[viewer,meshes]'
	touch $(VENV)/.demo $@

$(VENV)/.dev: pyproject.toml | $(RUN)/python
	$(RUN)/python -m pip install --quiet --upgrade 'pip>=25.1'
	$(RUN)/python -m pip install --quiet --editable '.[viewer,meshes]' --group dev
	touch $(VENV)/.demo $(VENV)/.video $@

clean:
	rm -rf $(VENV) $(BENCH_VENV) $(DOCS_VENV) $(CUDA_VENV) $(WHEEL_VENV) $(LOWEST_VENV) $(FRANKA_VENV) $(FRANKY_VENV) .venv-ros1 .venv-ros2 hw2.zip .pytest_cache .ruff_cache .hypothesis .import_linter_cache build

# make demo: set up and run the demo.  make test: set up and pass the tests.  Both may be run again and again.
PYTHON ?= python3
VENV ?= .venv
RUN = $(VENV)/bin
ARGS ?=

.PHONY: demo test clean

demo: $(VENV)/.demo
	$(RUN)/ulna demo $(ARGS)

# Everything that CI runs: style, types, layers, tests; then the kernels again without the compiler, and for a plain CPU.
test: $(VENV)/.dev
	$(RUN)/ruff check
	$(RUN)/ruff format --check
	$(RUN)/pyright --pythonpath $(RUN)/python
	$(RUN)/python -m pytest $(ARGS)
	NUMBA_DISABLE_JIT=1 $(RUN)/python -m pytest tests/unit/kernels
	NUMBA_CPU_NAME=generic $(RUN)/python -m pytest tests/unit/kernels

$(RUN)/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/.demo: pyproject.toml | $(RUN)/python
	$(RUN)/python -m pip install --quiet --disable-pip-version-check --editable '.[viewer]'
	touch $@

$(VENV)/.dev: pyproject.toml | $(RUN)/python
	$(RUN)/python -m pip install --quiet --upgrade 'pip>=25.1'
	$(RUN)/python -m pip install --quiet --editable '.[viewer,meshes]' --group dev
	touch $(VENV)/.demo $@

clean:
	rm -rf $(VENV) .pytest_cache .ruff_cache .hypothesis .import_linter_cache

# Two commands do everything on a machine with Python 3.11 and make: `make run` and `make test`.
PYTHON ?= python3.11
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready

.PHONY: run test test-fast lint types bench verify clean

run: $(READY)  ## tune the Table-2 buffer and say what was found
	$(BIN)/jaxbuffer tune optimise/table2.toml --output results/table2 --force

test: $(READY)  ## every test, the slow ones too
	$(BIN)/python -m pytest

test-fast: $(READY)  ## the tests without the slow ones
	$(BIN)/python -m pytest -m "not slow"

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

bench: $(READY)  ## wall times of capture, gradient and compilation
	$(BIN)/python -m benchmarks

verify: $(READY)  ## every check, deliberate breakages and the paper's claims: docs/verification.md
	$(BIN)/python -m verify

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable ".[dev]"
	touch $@

clean:
	rm -rf $(VENV) results .pytest_cache .mypy_cache .ruff_cache

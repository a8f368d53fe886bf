# Two commands do everything on a machine with make and Python 3.11 or later: `make run` and `make test`.
# The first of these that runs and is late enough makes the environment; `make PYTHON=…` names another.
of_pyenv = $(wildcard $(HOME)/.pyenv/versions/3.$(1)*/bin/python)
PYTHONS := python3.11 python3.12 python3.13 python3 $(foreach it,11 12 13,$(call of_pyenv,$(it)))
first_python = $(firstword $(foreach it,$(1),$(shell \
	$(it) -c 'import sys; print("$(it)" if sys.version_info >= (3, $(2)) else "")' 2>/dev/null)))
PYTHON ?= $(call first_python,$(PYTHONS),11)
# JAX's newest versions need a later Python than its oldest here: `make test` has the one, `make test-newest` the other.
NEWEST_PYTHONS := python3.13 python3.12 python3 $(foreach it,13 12,$(call of_pyenv,$(it)))
NEWEST_PYTHON ?= $(call first_python,$(NEWEST_PYTHONS),12)
NEWEST := .venv-newest
# Lanes and transitions of time stepping, settings of the process, a capture and its gradient.
NEWEST_TESTS := $(foreach it,batched_lanes kernel transitions,tests/hybrid/test_$(it).py) tests/programs/test_runtime.py \
	tests/docking/test_runs.py::test_the_papers_capture_did_not_move \
	tests/docking/test_runs.py::test_a_captures_gradient_is_that_of_its_differences
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
PEERS := $(VENV)/.peers
# There is a test process for each core: further threads, of linear algebra, would only get in their way.
# `make test PROGRAMS=folder` keeps what is compiled in a folder, for `make test-slow` with the same one.
PYTEST := OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist worksteal --durations 40 \
	--durations-min 5 $(if $(PROGRAMS),--programs=$(PROGRAMS))
SLOW := slow or whole or long
# Nearly all of the tests' time is compilation. Without LLVM's optimisations the 447 quick ones of tests/docking, run,
# sensitivities and elements take 127 instead of 187 s of processor; without XLA's alias metadata, which only these read,
# a docking's loop compiles in 3.0 instead of 3.6 s. The comparisons with references in tests/verification, and the
# longest tests, run what users run.
AS_USERS_RUN := tests/verification
UNOPTIMISED := XLA_FLAGS="$$XLA_FLAGS --xla_backend_optimization_level=0 --xla_llvm_enable_noalias_metadata=false \
	--xla_llvm_enable_alias_scope_metadata=false"
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable

.PHONY: run studies test test-slow test-long test-newest lint types smoke bench bench-check bench-docs verify faults docs clean

run: $(READY)  ## tune the Table-2 buffer and say what was found
	$(BIN)/jaxbuffer tune optimise/table2.toml --output results/table2 --force

studies: $(READY)  ## the studies of optimise/, into results/studies
	$(BIN)/python -m optimise --resume

test: $(READY)  ## one test or more of each claim, command, page, mechanism, outcome and kind of bad input
	$(UNOPTIMISED) $(PYTEST) -m "not ($(SLOW))"

test-slow: $(READY)  ## the other tests but the longest
	$(UNOPTIMISED) $(PYTEST) -m "($(SLOW)) and not long" --ignore $(AS_USERS_RUN)
	$(PYTEST) -m "($(SLOW)) and not long" $(AS_USERS_RUN)

test-long: $(READY)  ## the longest, which CI leaves out
	$(PYTEST) -m long

test-newest:  ## some of the quick tests with the newest JAX, in an environment of its own, if a Python 3.12 or later is here
	@if [ -z "$(NEWEST_PYTHON)" ]; then \
		echo "test-newest: the newest JAX is not tried: none of $(NEWEST_PYTHONS) is Python 3.12 or later"; \
	else $(MAKE) --no-print-directory $(NEWEST)/.tested; fi

$(NEWEST)/.ready: pyproject.toml constraints.txt
	$(NEWEST_PYTHON) -m venv $(NEWEST)
	$(NEWEST)/bin/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt \
		--editable . beartype hypothesis jsonschema pytest pytest-xdist
	touch $@

.PHONY: $(NEWEST)/.tested
$(NEWEST)/.tested: $(NEWEST)/.ready
	$(NEWEST)/bin/python -c "import sys, jax; print('JAX', jax.__version__, 'on Python', sys.version.split()[0])"
	$(subst $(BIN),$(NEWEST)/bin,$(PYTEST)) $(NEWEST_TESTS)

lint: $(READY)  ## style, and which package may import which
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports --no-logo --no-cache

types: $(READY)  ## of all source, and what two checkers say of calls as users write them
	$(BIN)/mypy
	$(BIN)/basedpyright

smoke: $(READY)  ## wheel and sdist build, install into environments of their own, and run there; oldest and newest Python
	.ci/smoke $(BIN)/python $(NEWEST_PYTHON)
	$(if $(NEWEST_PYTHON),,@echo "smoke: not tried with the newest Python: none of $(NEWEST_PYTHONS) is 3.12 or later")

bench: $(PEERS)  ## speed against SciPy and SUNDIALS at equal accuracy, into benchmarks/results
	$(BIN)/python -m benchmarks

bench-check: $(PEERS)  ## the quick benchmarks; fails where a ratio to a peer is under its baseline by over 30 %
	$(BIN)/python -m benchmarks --quick --check-baseline

faults: $(READY)  ## kills of commands; kills, full disks, damage and strangers to a sweep over a scheduler: docs/clusters.md
	$(BIN)/python -m pytest tests/cli/test_lost_work_kills.py --kills 10
	$(BIN)/python -m verify.faults

bench-docs: $(READY)  ## the tables of the latest `make bench`, for docs/benchmarks.md
	$(BIN)/python -m benchmarks docs

verify: $(READY)  ## every check, deliberate breakages and the paper's claims: docs/generated/verified.md
	$(BIN)/python -m verify

docs: $(READY)  ## these pages as a site, docs/_build/html/index.html; a warning is an error
	$(BIN)/python -m sphinx -W --keep-going --quiet -b html docs docs/_build/html

$(READY): pyproject.toml constraints.txt
	$(if $(PYTHON),,$(error none of $(PYTHONS) is Python 3.11 or later: install one, or name it: make PYTHON=/path/to/python))
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) ".[dev]"
	touch $@

$(PEERS): $(READY)
	$(INSTALL) ".[bench]"
	touch $@

clean:
	rm -rf $(VENV) $(NEWEST) results docs/_build docs/generated .pytest_cache .mypy_cache .ruff_cache

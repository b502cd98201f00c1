# `make` lists what there is. On a fresh machine Python >= 3.11, pip and make are enough; the rest goes into .venv.
PYTHON ?= python3
JOBS ?= auto
OUT ?= out

VENV := .venv
STAMP := $(VENV)/.complete
BIN := $(VENV)/bin
PIP_INSTALL := -m pip install --quiet --disable-pip-version-check
PYTEST := $(BIN)/python -m pytest -n $(JOBS) --maxprocesses=8 --dist worksteal

# Where it is set, each of the tests' hundreds of processes would compile the package anew, and pytest every test.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help venv grasp test test-all check format bench trials docs studies clean distclean

help:  ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' $(firstword $(MAKEFILE_LIST))

venv: $(STAMP)  ## what the other targets need, in .venv (about 2 GB; minutes the first time, nothing after)

# The stamp comes last and goes first, so that an interrupted installation starts afresh; with a stamp, only what
# changed is installed. Two makes at once take turns, where there is flock, and the second finds the work done.
# Debian without python3-venv has venv but no ensurepip: there pip installs itself from outside. What pip would compile
# file by file is compiled on all cores.
$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	  echo "make: Python 3.11 or newer is needed, and $(PYTHON) is not; try make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 2; }
	@exec 9>.venv.lock; if command -v flock >/dev/null; then flock 9; fi; \
	if test $@ -nt pyproject.toml && test $@ -nt constraints.txt; then exit 0; fi; \
	echo "Installing into $(VENV) ..." >&2; \
	if test -e $@; then rm -f $@; \
	elif $(PYTHON) -c 'import ensurepip' 2>/dev/null; then $(PYTHON) -m venv --clear $(VENV); \
	else $(PYTHON) -m venv --clear --without-pip $(VENV) && $(PYTHON) -m pip --python $(BIN)/python install --quiet pip; \
	fi || { echo "make: $(PYTHON) cannot make a virtual environment; on Debian and Ubuntu: apt install python3-venv" >&2; exit 2; }; \
	$(BIN)/python $(PIP_INSTALL) --no-compile -c constraints.txt -e '.[dev]' && \
	{ $(BIN)/python -m compileall -q -j 0 -x '/tests?/' $(VENV)/lib >/dev/null 2>&1 || true; } && touch $@

grasp: $(STAMP)  ## one grasp in simulation: video, pictures and result.json in out/grasp
	$(BIN)/spiraltrunk grasp --out $(OUT)/grasp

test: $(STAMP)  ## the fast tests
	$(PYTEST)

test-all: $(STAMP)  ## every test
	$(PYTEST) -m ""

check: $(STAMP)  ## lint, format, types, import contracts
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	PYTHONUTF8=1 $(BIN)/lint-imports

format: $(STAMP)  ## put the code into the house's format
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

bench: $(STAMP)  ## measure the performance claims
	$(BIN)/spiraltrunk bench --out $(OUT)/bench
	$(BIN)/python benchmarks/speed.py --out $(OUT)/bench

trials: $(STAMP)  ## 50 drawn grasps, of which 48 are to succeed (minutes)
	$(BIN)/python benchmarks/grasp_trials.py --out $(OUT)/trials

docs: $(STAMP)  ## the documentation site in out/docs, its links checked
	$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going --jobs auto -d $(OUT)/doctrees docs $(OUT)/docs
	$(BIN)/python docs/_ext/check_links.py $(OUT)/docs

studies: $(STAMP)  ## make the pictures and numbers of README and docs again (minutes to hours)
	$(BIN)/python docs/studies/make_pictures.py
	$(BIN)/python docs/studies/study_forward_models.py
	$(BIN)/python docs/studies/study_stiffness.py
	$(BIN)/python docs/studies/study_motion_capture.py
	$(BIN)/python docs/studies/make_making.py
	$(BIN)/python docs/studies/make_studio.py
	$(BIN)/python docs/studies/study_everyday.py --out $(OUT)/everyday
	$(BIN)/python docs/studies/rank_everyday.py
	$(BIN)/python docs/studies/make_everyday.py --rules $(OUT)/everyday

clean:  ## remove caches and build products; out and .venv stay
	rm -rf build dist docs/examples src/*.egg-info .pytest_cache .hypothesis .mypy_cache .ruff_cache .import_linter_cache
	find src tests benchmarks examples docs -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

distclean: clean  ## remove .venv as well
	rm -rf $(VENV) .venv.lock

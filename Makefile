# Everything a developer does with drysim. Needs Python 3.11 or newer; the rest is installed into .venv.
# Another interpreter: make PYTHON=python3.13 install, make OLDEST=python3.13 minimum

PYTHON ?= python3
VENV := .venv
RUN := $(VENV)/bin/python -m
OLDEST ?= python3.11
MINIMUM := .venv-minimum
READY := $(VENV)/.ready
TOOLS := $(VENV)/.tools
INPUTS ?= 1000000
CHANGES ?= 6
SLOW ?= slow
FILES ?=
SHARED := --numprocesses auto --maxprocesses 4 --dist loadfile

.DEFAULT_GOAL := help
.PHONY: help install fmt lint types layers test minimum slow fuzz mutate coverage check bench entries proof scale laws demo paper readme docs pictures schema clean

help: ## print this list
	@awk -F ':.*## ' '/^[a-z]+:.*## /{printf "  make %-8s %s\n", $$1, $$2}' Makefile

install: $(TOOLS) ## make .venv with drysim and the tools of its developers

# Stamps come last, so an interrupted installation starts afresh.
$(READY): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "drysim needs Python 3.11 or newer; name one: make PYTHON=python3.11 install" >&2; exit 1; }
	@echo "installing drysim into $(VENV): numpy, scipy, numba, matplotlib and some more"
	@$(PYTHON) -m venv $(VENV)
	@$(RUN) pip install --quiet --disable-pip-version-check --upgrade 'pip>=25.1' # knows --group
	@$(RUN) pip install --quiet --disable-pip-version-check --editable .
	@$(RUN) compileall -q src
	@touch $@

$(TOOLS): $(READY)
	@echo "installing the developers' tools into $(VENV)"
	@$(RUN) pip install --quiet --disable-pip-version-check --editable . --group dev
	@touch $@

fmt: $(TOOLS) ## put the code into shape
	$(RUN) ruff check --fix src tests docs
	$(RUN) ruff format src tests docs

lint: $(TOOLS) ## ruff: rules and shape; codespell
	$(RUN) ruff check src tests docs
	$(RUN) ruff check --quiet --preview --select PLW1514 src # each file names its encoding
	$(RUN) ruff format --check src tests docs
	$(RUN) codespell_lib src scenarios docs README.md

types: $(TOOLS) ## mypy, strict, for Linux, macOS and Windows
	$(foreach system,linux darwin win32,$(RUN) mypy --platform $(system) --cache-dir .mypy_cache/$(system) &&) true

layers: $(TOOLS) ## who may import whom
	PYTHONPATH=src $(VENV)/bin/lint-imports --no-logo

test: $(TOOLS) ## the tests, all but the slow ones; five minutes on two cores
	$(RUN) pytest -m "not slow" $(SHARED)

minimum: $(MINIMUM)/.ready ## the same tests on the lowest versions declared, of those with a wheel
	$(MINIMUM)/bin/python -m pytest -m "not slow" $(SHARED)

$(MINIMUM)/.ready: pyproject.toml
	$(OLDEST) -m venv --clear $(MINIMUM)
	$(MINIMUM)/bin/python -m pip install --quiet --disable-pip-version-check uv
	$(MINIMUM)/bin/uv pip install --quiet --python $(MINIMUM) --resolution lowest-direct \
	  --only-binary :all: --no-binary drysim --editable . \
	  --requirements pyproject.toml --all-extras --group test
	@touch $@

# Some of the slow tests start processes of their own.
slow: $(TOOLS) ## the slow tests; up to an hour on two cores, a quarter by SLOW="slow and not by_hand"
	$(RUN) pytest -m "$(SLOW)" $(SHARED) --maxprocesses 2

fuzz: $(TOOLS) ## a million damaged inputs to every reader; fewer by make INPUTS=10000 fuzz
	cd tests && PYTHONPATH=tools ../$(RUN) fuzz --inputs $(INPUTS)

mutate: $(TOOLS) ## change the core in one place at a time, and see whether tests notice; hours
	$(VENV)/bin/python tests/tools/mutate.py $(CHANGES) $(FILES)

coverage: $(TOOLS) ## branch coverage of src under the plain engine, gaps named; a quarter of an hour
	$(RUN) coverage erase
	DRYSIM_ENGINE=plain $(RUN) coverage run -m pytest -m "not slow" $(SHARED)
	$(RUN) coverage combine --quiet
	$(RUN) coverage report

check: lint types layers test ## all but the slow tests

bench: $(TOOLS) ## count the instructions of a few jobs, say what changed; keep the counts by STORE=1
	$(VENV)/bin/python tests/bench/watch.py $(if $(STORE),--store)

entries: $(TOOLS) ## time every entry of drysim bench by pytest-benchmark; apart from the tests
	$(RUN) pytest tests/bench -o python_files='speed_*.py' --benchmark-max-time=0.3 \
	  --benchmark-columns=min,median,iqr,rounds --benchmark-group-by=group

proof: $(TOOLS) ## measure the table of speed and error in README.md anew; some minutes
	$(VENV)/bin/python tests/tools/proof.py

scale: $(TOOLS) ## measure what a case of a large sweep costs, in threads and on a cluster; a minute
	$(VENV)/bin/python tests/tools/scale.py

laws: $(TOOLS) ## time the laws without a closed form beside scipy's integrators; half a minute
	$(VENV)/bin/python tests/tools/law_speed.py

demo: $(READY) ## compute and draw a seat on a recorded base motion, and the paper's Fig. 3
	@echo "a driver's seat on a recorded floor: drysim run scenarios/seat-on-em1.yaml"
	@$(RUN) drysim run scenarios/seat-on-em1.yaml --out out/seat-on-em1
	@echo "its picture: out/seat-on-em1/response.png"
	@echo "288 harmonic cases: drysim sweep scenarios/paper-low-friction.yaml"
	@$(RUN) drysim sweep scenarios/paper-low-friction.yaml --out out/paper-low-friction
	@echo "The pictures:"; ls out/seat-on-em1/*.png out/paper-low-friction/*.png

paper: $(READY) ## compute and draw the paper's Figs. 1, 3, 4 and 5, also by its own method; half a minute
	$(RUN) drysim run scenarios/paper-high-friction.yaml --set friction.static_ratio=1.2 --set excitation.frequency=0.7 --out out/paper-friction
	$(RUN) drysim sweep scenarios/paper-low-friction.yaml --out out/paper-low-friction
	$(RUN) drysim sweep scenarios/paper-high-friction.yaml --out out/paper-high-friction
	$(RUN) drysim sweep scenarios/paper-random.yaml --out out/paper-random
	$(RUN) drysim compare signum vs stick-slip scenarios/paper-random.yaml --out out/paper-random-compare
	$(RUN) drysim compare switch vs stick-slip scenarios/paper-low-friction.yaml --out out/paper-low-friction-switch
	$(RUN) drysim compare switch vs stick-slip scenarios/paper-high-friction.yaml --out out/paper-high-friction-switch
	$(RUN) drysim compare switch vs stick-slip scenarios/paper-random.yaml --out out/paper-random-switch
	@echo "The pictures:"; ls out/paper-*/*.png

readme: $(TOOLS) ## write tables and console output of README.md and the manual anew
	$(VENV)/bin/python tests/tools/readme.py

docs: $(TOOLS) ## build the manual as a web site in out/site
	$(VENV)/bin/python docs/build.py out/site

pictures: $(TOOLS) ## draw the pictures of README.md and the manual
	$(VENV)/bin/python scenarios/pictures/draw.py

schema: $(READY) ## write the JSON schema of scenarios beside the gallery
	$(RUN) drysim schema > scenarios/scenario.schema.json.new
	mv scenarios/scenario.schema.json.new scenarios/scenario.schema.json

clean: ## remove .venv, caches and builds; results in out/ stay
	rm -rf $(VENV) $(MINIMUM) build dist .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .coverage*
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +

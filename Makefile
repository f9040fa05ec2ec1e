# Two commands: `make studio` starts the studio, `make test` runs every check. Both set the environment up first.
PYTHON ?= python3
VENV ?= .venv
PROCESSES ?= 2
BIN := $(VENV)/bin

.PHONY: studio test setup setup-dev lint unit browser-tests chromium postgres openssl warm bench docs presets lock clean

studio: setup
	@$(BIN)/glider-studio serve

test: setup-dev chromium postgres openssl lint unit

setup: $(VENV)/run.stamp
setup-dev: $(VENV)/dev.stamp

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed; set PYTHON=python3.11" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)

$(VENV)/run.stamp: requirements/run.txt pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements/run.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-build-isolation --no-deps -e .
	@touch $@

$(VENV)/dev.stamp: requirements/dev.txt $(VENV)/run.stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements/dev.txt
	@touch $@

lint:
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# A file's tests stay together, for they share what is slow to set up. Those in the browser come last, beside no others.
unit:
	$(BIN)/python -m pytest -n $(PROCESSES) --dist loadfile --ignore=tests/browser
	$(BIN)/python -m pytest -n $(PROCESSES) --dist loadfile tests/browser

browser-tests: setup-dev chromium
	$(BIN)/python -m pytest -n $(PROCESSES) --dist loadfile tests/browser

# Debian's Chromium drives the browser tests; installed where that is allowed, else the tests say that it is missing.
chromium:
	@command -v chromium >/dev/null || { [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null \
	  && apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium fonts-dejavu-core; } \
	  || echo "chromium is missing and cannot be installed here: the browser tests will fail"

# Debian's PostgreSQL, of which the tests of the store start one of their own; they do not use one that runs already.
postgres:
	@ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || command -v initdb >/dev/null \
	  || { [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null \
	  && apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends postgresql; } \
	  || echo "PostgreSQL is missing and cannot be installed here: the tests of the store will fail"

# Makes the certificate of the cluster that docs/scale.md sets up, whose commands the tests run.
openssl:
	@command -v openssl >/dev/null || { [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null \
	  && apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends openssl; } \
	  || echo "openssl is missing and cannot be installed here: the test of docs/scale.md will fail"

warm: setup
	$(BIN)/python -c 'from models.warm import warm_analyses, warm_batch; warm_analyses(); warm_batch()'

bench: setup-dev
	$(BIN)/python -m benchmarks.planar
	$(BIN)/python -m benchmarks.spatial
	$(BIN)/python -m benchmarks.control
	$(BIN)/python -m benchmarks.linear
	$(BIN)/python -m benchmarks.trim
	$(BIN)/python -m benchmarks.latency
	$(BIN)/python -m benchmarks.lanes
	$(BIN)/python -m benchmarks.batch
	$(BIN)/python -m benchmarks.results
	$(BIN)/python -m benchmarks.store
	$(BIN)/python -m benchmarks.service
	$(BIN)/python -m benchmarks.startup

docs: setup-dev
	$(BIN)/python -m docs.make_equations
	$(BIN)/python -m docs.make_paper
	$(BIN)/python -m docs.make_quad_glider
	$(BIN)/python -m docs.make_control
	$(BIN)/python -m docs.make_validation
	$(BIN)/python -m docs.make_operations
	$(BIN)/python -m docs.make_batch

presets: setup
	$(BIN)/python -m models.presets.build

# Needs uv. The files name no index and carry the hashes of every platform's wheels.
lock:
	uv pip compile pyproject.toml --extra build --universal --python-version 3.11 --generate-hashes --no-annotate --no-header -q -o requirements/run.txt
	uv pip compile pyproject.toml --extra build --extra dask --extra postgres --extra dev -c requirements/run.txt --universal --python-version 3.11 --generate-hashes --no-annotate --no-header -q -o requirements/dev.txt

clean:
	rm -rf $(VENV)

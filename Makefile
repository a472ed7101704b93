# Every target does its own set-up; see CONTRIBUTING.md.
VENV := .venv
STAMP := $(VENV)/.installed
BIN := $(VENV)/bin
# Tests start Python hundreds of times: compiled files are kept. Neighbouring tests share what they
# set up, so each process begins with half of the suite and takes from the other when it is done.
PYTEST := PYTHONDONTWRITEBYTECODE= $(BIN)/pytest -n 2 --dist worksteal
# What solves equations or compares measures, so that rounding may turn a decision; of what is read
# the mat's cameras and poses, for other readers only take numbers from files.
NUMERICAL := $(addprefix tests/perception/,detection estimation facts online pieces reading/mat \
	shapes space surfaces test_line_drawing.py test_stable_order.py)
export FACETLOG_DATA ?= $(wildcard ../shared/data)
.DEFAULT_GOAL := help
.PHONY: help setup demo test test-all test-kernels check format reference docs bench mutants vsix lock clean

help: ## this list
	@sed -n 's/^\([a-z-]*\):[^#]*## \(.*\)/make \1\t\2/p' Makefile | expand -t 20

setup: $(STAMP) ## Debian packages, virtual environment, locked dependencies; nothing if done
$(STAMP): requirements.lock pyproject.toml scripts/setup
	scripts/setup $(VENV)
	touch $@

demo: $(STAMP) ## render a block, recognise it, write pictures to out/demo
	$(BIN)/facetlog demo -o out/demo

test: $(STAMP) ## the quick tests: everything but the marker slow
	$(PYTEST)

test-all: test ## all tests: the quick ones, then the slow ones
	$(PYTEST) -m slow

# OpenBLAS chooses its kernels by the processor, and each rounds in its own way; Sandybridge runs on
# every x86-64 processor with AVX, and differs from what AMD and newer Intel processors choose.
test-kernels: $(STAMP) ## the numerical tests with other kernels of OpenBLAS; only on x86-64
ifeq ($(shell uname -m)/$(OPENBLAS_CORETYPE),x86_64/)
	OPENBLAS_CORETYPE=Sandybridge $(PYTEST) -m "slow or not slow" $(NUMERICAL)
else
	@echo "test-kernels: nothing to do, this is $$(uname -m) with OPENBLAS_CORETYPE=$$OPENBLAS_CORETYPE"
endif

check: $(STAMP) ## before a commit: format, lint, types, import contracts, quick tests
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(PYTEST)

bench: $(STAMP) ## measure everything, and write docs/benchmarks.md and out/benchmarks.md
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks --write

mutants: $(STAMP) ## change each clause that judges in turn: which change would nobody notice?
	$(BIN)/python scripts/mutants.py

format: $(STAMP) ## put the Python files into form
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

reference: $(STAMP) ## draw the picture of words in docs/pictures
	$(BIN)/python scripts/draw_vocabulary.py

docs: $(STAMP) ## pages of the Python interface and of all words into out/docs, JSON Schemas into out/schemas
	$(BIN)/python scripts/write_schemas.py
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict --quiet

vsix: ## build the VS Code extension into dist/; needs Python alone
	python3 scripts/build_vsix.py

lock: $(STAMP) ## renew requirements.lock from pyproject.toml
	$(BIN)/python -m pip install --quiet uv
	$(BIN)/uv pip compile pyproject.toml --extra dev --universal --generate-hashes --no-emit-index-url --no-emit-find-links --quiet -o requirements.lock

clean: ## remove the environment, results and caches
	rm -rf $(VENV) out build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -prune -exec rm -rf {} +

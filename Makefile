# Every target does its own set-up; see CONTRIBUTING.md.
VENV := .venv
STAMP := $(VENV)/.installed
BIN := $(VENV)/bin
export FACETLOG_DATA ?= $(wildcard ../shared/data)
.PHONY: demo test check setup format bench lock clean

setup: $(STAMP)
$(STAMP): requirements.lock pyproject.toml scripts/setup
	scripts/setup $(VENV)
	touch $@

demo: $(STAMP)
	$(BIN)/facetlog demo -o out/demo

test: $(STAMP)
	$(BIN)/pytest -n 2 -m "slow or not slow"

check: $(STAMP)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/pytest -n 2

bench: $(STAMP)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks --write

format: $(STAMP)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

lock: $(STAMP)
	$(BIN)/python -m pip install --quiet uv
	$(BIN)/uv pip compile pyproject.toml --extra dev --universal --generate-hashes --no-emit-index-url --no-emit-find-links --quiet -o requirements.lock

clean:
	rm -rf $(VENV) out

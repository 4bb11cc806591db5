# Two commands do all the set-up: `make demo` and `make test`. `make check` is what a change must pass.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CORE := $(VENV)/.core-ready
DEV := $(VENV)/.dev-ready
PIP_INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check

# Real maps: tests read them from the folder CONAV_DATA names and skip without it.
.PHONY: demo test check check-static format benchmark lock clean

demo: $(CORE)
	$(BIN)/conav explore office --robots 3 --seed 1 --out demo.mcap --png demo.png --gif demo.gif
	@echo
	@echo "Watch it:   open demo.gif (or demo.png for the last picture) in any viewer or browser."
	@echo "Check it:   $(BIN)/conav verify demo.mcap"
	@echo "Your map:   $(BIN)/conav explore path/to/map.yaml --robots 3 --gif mine.gif"

test: $(DEV)
	$(BIN)/python -m pytest -n 2 --dist loadgroup

check: check-static test

check-static: $(DEV)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/pyright
	$(BIN)/lint-imports

format: $(DEV)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

benchmark: $(DEV)
	$(BIN)/python benchmarks/explore_speed.py
	$(BIN)/python benchmarks/start_up.py

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit("conav needs Python 3.11 or newer; this is " + sys.version.split()[0] + ". Try: make PYTHON=python3.12") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)

$(CORE): $(VENV)/bin/python requirements.txt pyproject.toml
	@echo "Setting up $(VENV) (about half a minute) ..."
	$(PIP_INSTALL) --require-hashes -r requirements.txt
	$(PIP_INSTALL) --no-deps --no-build-isolation -e .
	@touch $@

$(DEV): $(CORE) requirements-dev.txt
	@echo "Adding the development tools ..."
	$(PIP_INSTALL) --require-hashes -r requirements-dev.txt
	@touch $@

# Needs uv (pip install uv). The exported files carry hashes and no addresses; uv.lock itself is not kept.
lock:
	uv lock --quiet
	uv export --quiet --no-emit-project --no-header --no-dev --group build --format requirements-txt -o requirements.txt
	uv export --quiet --no-emit-project --no-header --format requirements-txt -o requirements-dev.txt

clean:
	rm -rf $(VENV) .pytest_cache .ruff_cache .hypothesis build dist demo.mcap demo.png demo.gif

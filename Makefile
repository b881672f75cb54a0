# armtwin: `make demo` runs the paper's experiment on the simulated bench, `make test` checks everything.
# Both set up what they need: system packages, uv, a virtual environment from the lock file.

SHELL := /bin/sh
# Installed into build/uv where no uv is on the path.
export UV_VERSION := 0.13.9

BIN := .venv/bin
ENVIRONMENT := .venv/.armtwin-environment
SYSTEM := build/stamps/system-packages
AVR := build/stamps/avr-packages
BROWSER := build/stamps/browser

# Software OpenGL through EGL: rendering needs neither a GPU nor a display. libXrender is bound when pyrender's window
# library is imported, although no window is ever opened.
SYSTEM_PACKAGES := libegl1 libgl1 libgles2 libgl1-mesa-dri libxrender1
# The Uno's firmware is compiled and run in an emulator by some tests.
AVR_PACKAGES := gcc-avr avr-libc arduino-core-avr simavr libsimavr-dev libelf-dev gcc libc6-dev

# The reports are opened in a browser by some tests.
BROWSER_PACKAGES := chromium

# One thread a worker: two test workers on two cores.
THREADS := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1 LP_NUM_THREADS=1

.PHONY: upload help setup demo test test-slow nightly check seal-score seal-score-moving sweep fuzz fuzz-inputs docs bench clean

help:
	@echo "make demo    run the paper's experiment on the simulated bench; the report is out/paper/report.html"
	@echo "make test    set up, then style, types, import rules and tests"
	@echo "make test-slow   the long tests"
	@echo "make nightly     hidden effects with fresh seeds"
	@echo "make setup   set up only"
	@echo "make seal-score  hide effects in 360 worlds, 60 of them rendered, and score the diagnosis"
	@echo "make seal-score-moving  hide effects in 240 logs of moving arms and score the diagnosis"
	@echo "make sweep   the standing map of what is found: up to 10,944 worlds, gone on with where it was broken off"
	@echo "make fuzz    10,000 broken frames at both ends of the serial line"
	@echo "make fuzz-inputs  5,000 spoilt files of every kind, half of them by a fresh seed"
	@echo "make docs    the documentation site: build/site/index.html, which opens without a network"
	@echo "make upload PORT=/dev/ttyACM0   the firmware into an Arduino Uno"
	@echo "make bench   the benchmarks, one after the other, on an idle machine"
	@echo "make clean   remove what was built and run, and the virtual environment"

setup: $(SYSTEM) $(ENVIRONMENT)

demo: setup
	$(BIN)/armtwin run paper --out out/paper

test: setup $(AVR) $(BROWSER) check
	$(THREADS) $(BIN)/pytest -n 2 --dist loadgroup -m "not slow"

# Whole captures on the emulated bench with faults injected, whole runs.
test-slow: setup $(AVR)
	$(THREADS) $(BIN)/pytest -n 2 --dist loadgroup -m slow

# Hidden effects again, in worlds that nobody has seen; a failure's name tells its seed.
FRESH := 3
nightly: setup
	ARMTWIN_FRESH_SEEDS=$(FRESH) $(THREADS) $(BIN)/pytest -n 2 tests/integration/test_hidden_effects.py

check: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# A set of worlds of its own for every seed: make seal-score SEED=7
SEED := 1
seal-score: setup
	$(BIN)/armtwin seal --n 300 --seed $(SEED) --pairs --uncatalogued tests/support/uncatalogued.py --out out/sealed-$(SEED)
	$(BIN)/armtwin seal --n 60 --seed $(SEED) --frames --out out/sealed-$(SEED)-frames
	$(BIN)/armtwin score out/sealed-$(SEED)
	$(BIN)/armtwin score out/sealed-$(SEED)-frames

# The same for logs of a moving arm.
seal-score-moving: setup
	$(BIN)/armtwin seal --moving --n 240 --seed $(SEED) --out out/sealed-moving-$(SEED)
	$(BIN)/armtwin score out/sealed-moving-$(SEED)

# The map in docs/explanation/power.md; hours on two cores, and a scheduler takes it to more: SCHEDULER=tcp://host:8786.
# In pieces: `make sweep PIECE=500`, again and again.
sweep: setup
	$(BIN)/armtwin sweep scenarios/sweeps/standing.toml --out out/sweep $(if $(SCHEDULER),--scheduler $(SCHEDULER)) $(if $(PIECE),--at-most $(PIECE))

fuzz: setup $(AVR)
	$(BIN)/python -m armtwin.hardware.emulator.fuzz --frames 10000

docs: setup
	$(BIN)/python docs/build_pages.py
	$(BIN)/mkdocs build --strict --quiet

PORT := /dev/ttyACM0
upload: $(AVR)
	.ci/system-packages avrdude
	$(MAKE) -C hardware/firmware/armtwin_firmware upload PORT=$(PORT) BUILD=$(CURDIR)/build/firmware

MUTATIONS := 5000
fuzz-inputs: setup
	$(THREADS) PYTHONPATH=. $(BIN)/python -m tests.fuzz.fuzz_inputs --mutations $(MUTATIONS)

bench: setup $(AVR)
	for bench in tests/benchmarks/bench_*.py; do echo "== $$bench"; PYTHONPATH=. $(BIN)/python $$bench || exit; done

$(SYSTEM): .ci/system-packages Makefile
	.ci/system-packages $(SYSTEM_PACKAGES)
	@mkdir -p $(@D) && touch $@

$(AVR): .ci/system-packages Makefile
	.ci/system-packages --optional $(AVR_PACKAGES)
	@mkdir -p $(@D) && touch $@

$(BROWSER): .ci/system-packages Makefile
	.ci/system-packages --optional $(BROWSER_PACKAGES)
	@mkdir -p $(@D) && touch $@

$(ENVIRONMENT): requirements.lock pyproject.toml .ci/find-python .ci/find-uv
	python=$$(.ci/find-python) && uv=$$(.ci/find-uv) && \
	{ $(BIN)/python -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' 2>/dev/null || \
	  $$uv venv --quiet --clear --python "$$python" .venv; } && \
	$$uv pip sync --quiet --python $(BIN)/python --require-hashes requirements.lock && \
	$$uv pip install --quiet --python $(BIN)/python --no-deps --editable .
	@touch $@

clean:
	rm -rf .venv build out

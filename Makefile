# `make demo` and `make test` do all their own set-up; nothing else is needed but Python 3.11+.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt

# Tests start hundreds of programs: where Python may not keep what it compiled, each does it anew.
unexport PYTHONDONTWRITEBYTECODE

.DELETE_ON_ERROR:
.PHONY: help demo test test-slow lint bench soak stateful fuzz reaches learn clean

help:  ## what there is
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 10

demo: $(VENV)/.run  ## reach for three targets on the simulated human-like arm, with plots in out/
	@mkdir -p out
	$(BIN)/armsyn reach --target 0.35 -0.10 -0.15 --return --record out/reach-1.npz --plot out/reach-1.png
	$(BIN)/armsyn reach --target 0.42 -0.25 -0.05 --plot out/reach-2.png
	$(BIN)/armsyn reach --target 0.40 0.15 0.02 --park --plot out/reach-3.png
	@echo "The hand's speed, captured, planned, measured and without synergy: out/reach-[123].png"

# Tests on the clock of the wall want the machine to themselves: two at a time save minutes, so what
# failed beside another one (or while the machine stood still) is judged once more, alone, and said.
PYTEST := $(BIN)/python -m pytest -q
ALONE = { echo "Once more, one at a time, what failed:"; \
	$(PYTEST) --last-failed --last-failed-no-failures none -m $(1); }

test: $(VENV)/.test  ## what must hold, in ten minutes; the first time kernels are compiled, a few more
	$(PYTEST) -n auto --dist loadfile -m "not realtime and not slow"
	$(PYTEST) -n 2 --dist loadfile -m "realtime and not slow" || $(call ALONE,"realtime and not slow")

test-slow: $(VENV)/.test  ## the rest of what must hold, in some minutes more
	$(PYTEST) -m "slow and not realtime"
	$(PYTEST) -m "slow and realtime" || $(call ALONE,"slow and realtime")

lint: $(VENV)/.test  ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: $(VENV)/.test  ## speed, memory and success rates, side by side in one run
	@status=0; for bench in rollout learning editing bus stream track simulator ik planning formats generate memory; do \
		echo; $(BIN)/python tests/benchmarks/bench_$$bench.py || status=1; done; exit $$status

soak: $(VENV)/.run  ## a million bus cycles on simulated servos while things go wrong (ten minutes)
	$(BIN)/python tests/benchmarks/soak.py

stateful: $(VENV)/.test  ## 10,000 random steps of driver, arm and operator, each end judged (20 minutes)
	$(BIN)/python tests/benchmarks/stateful.py --steps 10000

MINUTES ?= 30
fuzz: $(VENV)/.run  ## hostile bytes against simulated servos, for MINUTES=30
	$(BIN)/python tests/benchmarks/fuzz.py $(MINUTES)

reaches: $(VENV)/.run  ## twenty random targets on the simulated arm, with and without synergy
	$(BIN)/python tests/benchmarks/random_reaches.py

GARZA := --captures garza:all --learner annealing --generations 150 \
	--model C --model A --model B --model D --ik svd --ik jt --ik njt --ik dls
learn: $(VENV)/.run  ## learn the arms' synergies and atlases anew (needs the captures; an hour)
	$(BIN)/armsyn learn --arm human7 $(GARZA) --out calibration/human7.synergies.json
	$(BIN)/armsyn learn --arm openmanipulator_x $(GARZA) --out calibration/openmanipulator_x.synergies.json
	$(BIN)/armsyn learn --arm koch $(GARZA) --out calibration/koch.synergies.json
	@for arm in widowx_250s viperx_300s reachy_right; do \
		$(BIN)/armsyn learn --arm $$arm --captures garza:all --learner annealing --generations 150 --model C --model A \
			--ik svd --ik dls --out calibration/$$arm.synergies.json || exit 1; done
	@for arm in human7 widowx_250s viperx_300s openmanipulator_x koch; do \
		$(BIN)/armsyn learn --atlas --arm $$arm --captures garza:all \
			--out calibration/$$arm.atlas.json || exit 1; done

clean:  ## remove what make made
	rm -rf $(VENV) out

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "$(PYTHON) is missing or older than 3.11: install Python 3.11 or newer, or name it:" \
			"make PYTHON=python3.12 ..."; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
		echo "$(PYTHON) cannot make virtual environments. On Debian and Ubuntu:" \
			"sudo apt-get install python3-venv (or python3.11-venv, for your version);" \
			"on Fedora: sudo dnf install python3"; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) -e .
	@touch $@

$(VENV)/.test: pyproject.toml constraints.txt | $(BIN)/python
	$(INSTALL) -e '.[test,lint]'
	@touch $@ $(VENV)/.run

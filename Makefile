# make demo: one small transfer, in minutes.  make repro: from demonstrations to results.
# make test: the tests.  Each sets up what it needs:
# uv in .uv/ if the machine has none, Python 3.12 and the locked environment in .venv/.

SHELL := /bin/bash -e
UV := .uv/bin/uv
READY := .venv/.ready
export PATH := $(CURDIR)/.venv/bin:$(PATH)
# If uv has to fetch a Python, it goes into the project.
export UV_PYTHON_INSTALL_DIR := $(CURDIR)/.uv/python
unexport VIRTUAL_ENV

.PHONY: demo example site repro test test-slow check bench bench-checkers bench-stages evidence setup lock

demo: setup
	python -m pipeline._demo

repro: setup
	python -m pipeline._repro

test: setup
	pytest

test-slow: setup
	pytest -m slow

# The documentation as pages for a browser: work/site/index.html.
site: | $(UV)
	$(UV) tool run --quiet --from mkdocs==1.6.1 --with mkdocs-material==9.8.2 --with "mkdocstrings[python]==1.0.8" mkdocs build --quiet

# Meta-World's Sawyer teaches Gymnasium-Robotics' Fetch (docs/bring-a-dataset.md); hours.
example: setup
	$(UV) pip install --quiet --constraint requirements.lock gymnasium-robotics==1.4.2 metaworld==3.0.0
	python -m examples.metaworld_fetch

check: setup
	ruff check .
	ruff format --check .
	pyright
	lint-imports

# All that docs/evidence.md asks, some hours; goes on where it was stopped.
evidence: setup
	python -m studies.evidence
	python -m studies.evidence.page

# What the benchmarks compare with is no dependency of the project: it gets a folder of its own.
# Browsing is measured on a dataset of the project's.
bench: setup
	dvc repro --quiet pack@panda-joint_position-lift
	$(UV) pip install --quiet --no-deps --target .uv/benchmarks stable-baselines3==2.9.2
	export PYTHONPATH=.uv/benchmarks; \
	for benchmark in $(filter-out stages,$(basename $(notdir $(wildcard benchmarks/[a-z]*.py)))); do \
	  python -m benchmarks.$$benchmark; done

# Other checkers of datasets, each in an environment of its own, take hours; it goes on where it was stopped.
bench-checkers: setup
	python -m benchmarks.checkers
	python -m benchmarks.checkers.page

# Whole stages, of what is committed; they need the models that the main job makes.
bench-stages: repro
	python -m benchmarks.stages

setup: $(READY)

$(READY): requirements.lock pyproject.toml .python-version | $(UV)
	$(UV) venv --quiet --allow-existing .venv
	$(UV) pip sync --quiet --require-hashes requirements.lock
	$(UV) pip install --quiet --no-deps --editable . --editable plugins/lerobot_policy_lfr
	touch $@

# A pyenv shim may be there and not work, so it is tried. Debian's own python3 stands in for a
# shim of a version that is not installed.
$(UV):
	mkdir -p $(@D)
	if uv --version >/dev/null 2>&1; then ln -sf "$$(command -v uv)" $@; else \
	  python=python3; $$python --version >/dev/null 2>&1 || python=/usr/bin/python3; \
	  $$python -m venv .uv && .uv/bin/python -m pip install --quiet uv; fi

# Renews requirements.lock; it names packages and hashes, never the registry they came from.
lock: | $(UV)
	$(UV) pip compile pyproject.toml --extra pipeline --extra cluster --extra dev --universal --upgrade \
	  --generate-hashes --no-annotate --no-header --quiet -o requirements.lock
	! grep -n '://' requirements.lock

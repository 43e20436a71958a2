# SPDX-License-Identifier: GPL-3.0-or-later
# Every target sets up .venv first when it is missing or stale; `make PYTHON=/path/to/python3.13 test` chooses a Python.

SHELL := /bin/sh
PY := .venv/bin/python
export PYTHON

.DEFAULT_GOAL := help
.PHONY: help venv render bench report test test-all test-blender fuzz package samples lint clean

help:
	@echo "make render   path-trace sample_blends/cornell.blend to renders/cornell.png and .exr"
	@echo "make bench    measure Zraka beside Cycles; tables and plots in renders/bench"
	@echo "make report   error against run time of every sample scene, in build/reports (10 minutes)"
	@echo "make test     ruff and all tests"
	@echo "make test-blender  tests in whole Blenders, window and all (root on a Debian; see docs/blender.md)"
	@echo "make test-all      the tests without a window, in every Blender from 4.2 on that has a Python module"
	@echo "make fuzz     2,000 random scenes, and 500 made in Blender; about 20 minutes"
	@echo "make package       pack dist/zraka-*.zip for Blender, one a platform"
	@echo "make samples  write sample_blends/*.blend anew"
	@echo "make lint     ruff alone"
	@echo "make clean    remove .venv and what the tools left behind"

venv:
	@.ci/venv

render: venv
	@mkdir -p renders
	@$(PY) -m zraka render sample_blends/cornell.blend --method pathtrace \
		--output renders/cornell.png --output renders/cornell.exr

bench: venv
	@$(PY) -m zraka bench --suite quick --output renders/bench

# A minute for each of the 8 scenes, its page included.
report: venv
	@$(PY) -m zraka converge sample_blends/*.blend --time-limit 55 --output build/reports

test: lint
	@$(PY) -m pytest -n 2 --dist loadfile -m "not blender"

test-all: lint
	@.ci/test-all

test-blender: venv
	@$(PY) -m pytest tests/blender -m blender

fuzz: venv
	@$(PY) -m tests.fuzz --count 2000
	@$(PY) -m tests.fuzz --kind files --count 500
	@$(PY) -m tests.fuzz --kind blender --count 500

package: venv
	@$(PY) .ci/extension.py

lint: venv
	@$(PY) -m ruff check .
	@$(PY) -m ruff format --check .

samples: venv
	@$(PY) sample_blends/make.py

clean:
	rm -rf .venv .pytest_cache .ruff_cache zraka.egg-info build

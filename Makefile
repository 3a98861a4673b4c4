# softact. Every target that needs the program sets it up first; a second call sets nothing up.
.DEFAULT_GOAL := help
.PHONY: help run test lint docs docs-site benchmark setup constraints test-debian13 test-sid clean

SPEC ?= configs/pneunet_glove.yaml
# A run wants one process per core and gains little beyond two. nproc takes OMP_NUM_THREADS for a
# limit, and make 4.4 (Debian 13) hands the export below to this shell.
PROCS ?= $(shell n=$$(env -u OMP_NUM_THREADS nproc); echo $$((n < 2 ? n : 2)))
# One thread per process: processes times threads must not exceed the cores.
export OMP_NUM_THREADS ?= 1

help:  ## list the targets
	@sed -n 's/^\([a-z0-9-]*\):[^#]*## /\1\t/p' Makefile | expand -t 16

run: setup  ## solve SPEC (configs/pneunet_glove.yaml) and say where the report is
	.venv/bin/softact run $(SPEC) -n $(PROCS)

# A file of tests stays in one process, so that what its fixtures solve is solved once.
test: setup  ## run the test suite; ARGS="-k sphere" goes to pytest
	.venv/bin/python -m pytest -n $(PROCS) --dist loadfile $(ARGS)

lint: setup  ## check style, format and types
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	@if command -v shellcheck > /dev/null; then shellcheck .ci/run .ci/setup .ci/debian .ci/first_actuator; fi

docs: setup  ## write the generated pages in docs/
	for page in docs/*.py; do .venv/bin/python $$page || exit 1; done

docs-site: setup  ## build the documentation's site in build/site; a dead link is an error
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --strict -f .ci/site/mkdocs.yml

benchmark: setup  ## softact beside CalculiX on the same mesh (needs ccx)
	.venv/bin/python -m benchmarks.calculix

setup:  ## install what is missing: Debian packages, .venv, softact in it
	@.ci/setup

constraints: setup  ## keep the versions in .venv as the tested ones of this Debian release
	.ci/setup --keep-versions

test-debian13:  ## run the test suite in a Debian 13 root (in ~/.cache, made on first use)
	.ci/debian 13 test

test-sid:  ## the same in a root of Debian sid, as it is on the day that the root is made
	.ci/debian sid test

clean:  ## delete .venv, caches and results; roots go with .ci/debian RELEASE remove
	rm -rf .venv .pytest_cache .ruff_cache .mypy_cache .hypothesis build results ./*.egg-info
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

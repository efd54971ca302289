# Everything runs in .venv, which is made from the lock files once and again only when they change.
# `make help` says what there is.

PYTHON ?= $(shell for p in python3.13 python3.12 python3.11 python3; do \
	command -v $$p >/dev/null && $$p -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
DURATION ?= 60
BIN := .venv/bin

.DEFAULT_GOAL := help
.PHONY: help install demo test bench lock protobuf docs golden format clean

help: ## say what there is
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## /  make \1\t/' | expand -t 18

install: .venv/run.stamp ## everything that a bench needs, into .venv

demo: .venv/run.stamp ## the whole simulated bench in closed loop; DURATION=60 seconds, ARGUMENTS="--out DIR --json"
	@$(BIN)/nodal demo --duration $(DURATION) $(ARGUMENTS)

test: .venv/dev.stamp ## lint, types, import contracts, tests
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/pytest

BENCHMARKS = $(sort $(subst /,.,$(patsubst %/__main__,%,$(basename \
	$(shell grep -l '__name__ == "__main__"' benchmarks/*.py benchmarks/*/*.py) $(wildcard benchmarks/*/__main__.py)))))

bench: .venv/dev.stamp ## side-by-side measurements; takes minutes; NODAL_PHOTOGRAPHS names a folder of photographs
	@for one in $(BENCHMARKS); do echo "== $$one"; $(BIN)/python -m $$one || exit 1; done

golden: .venv/dev.stamp ## replay tests/data/*.mcap into themselves; only when other results are meant
	@for log in tests/data/*.mcap; do \
		$(BIN)/nodal replay $$log -o $$log.new && mv $$log.new $$log || exit 1; done

format: .venv/dev.stamp ## rewrite the code as the formatter wants it
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

protobuf: .venv/dev.stamp ## generate messaging/generated from messaging/proto
	$(BIN)/python -m grpc_tools.protoc -I messaging/proto \
		--python_out messaging/generated --pyi_out messaging/generated messaging/proto/nodal.proto

docs: .venv/dev.stamp ## write the references in docs/ anew from settings, topics and faults
	$(BIN)/python -m nodal.settings_reference docs/bench-file.md
	$(BIN)/python -m nodal.message_reference > docs/messages.md
	$(BIN)/python -m nodal.fault_reference > docs/faults.md

COMPILE = uv pip compile pyproject.toml --group install --universal --generate-hashes \
	--python-version 3.11 --no-header --quiet

lock: | python-found ## pin the newest allowed versions of everything in requirements*.lock
	tools=$$(mktemp -d) && trap "rm -rf $$tools" EXIT && $(PYTHON) -m venv $$tools && $$tools/bin/pip install --quiet uv && \
	PATH=$$tools/bin:$$PATH && \
	$(COMPILE) --upgrade --extra bench --extra plots -o requirements.lock && \
	$(COMPILE) --upgrade --extra bench --extra plots --extra export --extra cluster --extra dev -c requirements.lock -o requirements-dev.lock

clean: ## remove .venv and every cache; recordings in runs/ stay
	rm -rf .venv .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache dist
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.PHONY: python-found
python-found:
	@test -n "$(PYTHON)" || { echo 'make: no Python 3.11 or newer with venv was found; install one, or name it: make PYTHON=/path/to/python' >&2; exit 1; }

.venv/bin/pip: | python-found
	$(PYTHON) -m venv .venv

.venv/run.stamp: requirements.lock pyproject.toml | .venv/bin/pip
	$(BIN)/pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

.venv/dev.stamp: requirements-dev.lock .venv/run.stamp
	$(BIN)/pip install --quiet --disable-pip-version-check --require-hashes -r requirements-dev.lock
	@touch $@

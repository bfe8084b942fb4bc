# Each target sets up what it needs: a virtual environment from the hash-locked requirements, then Understudy
# itself, editable. It is set up again only when a lock or pyproject.toml changed.

PYTHON ?= python3
VENV ?= .venv
UV ?= uv
BIN := $(VENV)/bin
WORKERS ?= 2  # of the tests that make test leaves out

# A python3 that is too old gives way to a newer one beside it; a PYTHON that was named is taken at its word.
ifeq ($(origin PYTHON),file)
PYTHONS := $(PYTHON) python3.14 python3.13 python3.12 python3.11
else
PYTHONS := "$(PYTHON)"
endif

# A virtual environment holds absolute paths: one moved along with its folder, or whose Python is gone, is made anew.
ifneq ($(shell test -x "$(BIN)/python" && cat "$(VENV)/.place" 2>/dev/null),$(CURDIR))
MOVED := moved
endif

# uv, where there is one, installs in a tenth of the time. Files are compiled when they are first imported.
ifneq ($(shell command -v $(UV)),)
PIP_INSTALL = $(UV) pip install --quiet --python $(BIN)/python
else
PIP_INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile
endif

# Compiled files are kept, also where the environment says otherwise: each of some hundred processes of the tests would
# compile again all that it imports.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: help demo studio page protocol test test-rest test-all coverage soak bench experiments docs page-site dist format lock clean moved
.NOTPARALLEL:

help: ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## /\1 /p' $(MAKEFILE_LIST) | while read -r target what; do \
		printf '  make %-12s %s\n' "$$target" "$$what"; done

demo: $(VENV)/.run ## train a robot to forage, and see how well it learned (ARGS="--seed 7" passes more)
	$(BIN)/understudy demo forage $(ARGS)

studio: $(VENV)/.run ## train a robot in the browser (ARGS="forage --library mine" passes more)
	$(BIN)/understudy studio $(ARGS)

page: ## build the page of the studio from page/ (needs Node and npm; what it builds is committed)
	cd page && npm ci && npm run build

protocol: $(VENV)/.run ## write the page's types of messages, which are generated from those of the studio
	$(BIN)/python -m understudy.ui.web.protocol page/src/protocol.ts

CHECKS = $(BIN)/ruff check && $(BIN)/ruff format --check && $(BIN)/pydoclint src && $(BIN)/lint-imports && $(BIN)/mypy
PYTEST = $(BIN)/pytest --dist loadgroup
QUICK = not soak and not long and not timed
REST = (long or timed) and not soak

# Kernels are compiled beside the checks, so that no two test processes compile the same one.
test: $(VENV)/.dev ## style, types, layers, and all quick tests (ARGS passes more to pytest)
	@$(BIN)/python -m tests.compile_kernels & compiling=$$!; $(CHECKS); checked=$$?; wait $$compiling && exit $$checked
	$(PYTEST) --numprocesses auto -m "$(QUICK)" $(ARGS)

test-rest: $(VENV)/.dev ## the tests that make test leaves out; in browsers and with robots, where those are installed
	$(PYTEST) --numprocesses $(WORKERS) -m "$(REST)" $(ARGS)

test-all: ARGS := --durations=20 $(ARGS)
test-all: test test-rest ## everything that must hold, but for the tests that take long

# Kernels run as compiled code in the tests, and as plain Python in the second run, which shows their branches.
coverage: $(VENV)/.dev ## branch coverage of the source by the quick tests, with the ten least covered modules
	@mkdir -p build && rm -f build/coverage*
	$(BIN)/pytest --numprocesses auto --dist loadgroup -m "$(QUICK)" --cov --cov-report= $(ARGS)
	UNDERSTUDY_KERNELS=python $(BIN)/coverage run -m tests.kernel_modes > build/kernel_modes.json
	@$(BIN)/coverage combine --append --quiet
	@$(BIN)/coverage report --skip-covered --sort=cover > build/coverage.txt && head -n 12 build/coverage.txt
	@$(BIN)/coverage report --format=total

soak: $(VENV)/.dev ## the tests that take long
	$(BIN)/pytest -m soak -o faulthandler_timeout=0 $(ARGS)

bench: $(VENV)/.bench ## measure, beside the peers of the bench extra
	$(BIN)/understudy bench $(ARGS)

experiments: $(VENV)/.dev ## a small part of every published experiment, compared with what was published
	$(BIN)/understudy experiment all --quick $(ARGS)

docs: $(VENV)/.release ## build the documentation site into site/; a warning fails the build
	@try=; if $(BIN)/python tools/page_site.py build/try; then try="--tag try"; elif [ $$? -ne 2 ]; then exit 1; fi; \
	$(BIN)/sphinx-build $$try --fail-on-warning --keep-going --quiet --builder html docs site && rm -rf site/try && \
	if [ -n "$$try" ]; then cp -r build/try site/try; else echo "The documents are without Try it now."; fi
	@echo "Open site/index.html"

page-site: $(VENV)/.run ## write the studio as static files into site-studio/, which any web server can serve
	$(BIN)/python tools/page_site.py site-studio
	@echo "Serve it: $(BIN)/python -m http.server --directory site-studio"

dist: $(VENV)/.release ## build wheels, pure and with compiled kernels, and sdist into dist/; check and try all
	rm -rf dist
	$(BIN)/python -m hatchling build
	$(BIN)/python tools/compile_shipped.py build/compiled
	UNDERSTUDY_SHIPPED_KERNELS=build/compiled $(BIN)/python -m hatchling build -t wheel
	$(BIN)/twine check --strict dist/*
	$(BIN)/check-wheel-contents dist/*.whl
	$(BIN)/python tools/smoke_test.py dist

format: $(VENV)/.dev ## put the source in order
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

# Valid on every platform and Python; each holds the one before, so that all can share one environment.
COMPILE = $(UV) pip compile pyproject.toml --group build --universal --python-version 3.11 --generate-hashes \
	--no-header --no-annotate --quiet $(ARGS)

lock: ## lock what pyproject.toml asks for, keeping versions that still fit (ARGS=--upgrade renews them)
	@command -v $(UV) >/dev/null || { echo "Locking needs uv: pip install uv, then run make lock again." >&2; exit 1; }
	$(COMPILE) --output-file requirements.lock
	$(COMPILE) --extra dev --constraints requirements.lock --output-file requirements-dev.lock
	$(COMPILE) --extra dev --extra bench --constraints requirements-dev.lock --output-file requirements-bench.lock
	$(COMPILE) --extra dev --extra release --constraints requirements-dev.lock --output-file requirements-release.lock

clean: ## remove everything that make made here
	rm -rf $(VENV) build dist site site-studio docs/reference/api docs/reference/studies .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .hypothesis page/node_modules
	find src tests -name __pycache__ -prune -exec rm -rf {} +

$(VENV)/.place: $(MOVED)
	@python=$$(sh tools/find-python $(PYTHONS)) && echo "Making $(VENV) with $$python" \
		&& rm -rf $(VENV) && "$$python" -m venv $(VENV)
	@echo "$(CURDIR)" > $@

$(VENV)/.run: $(VENV)/.place requirements.lock pyproject.toml
	@echo "Installing requirements.lock into $(VENV) (a minute or two, once)"
	@$(PIP_INSTALL) --require-hashes -r requirements.lock
	@$(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	@touch $@

$(VENV)/.dev: $(VENV)/.place requirements-dev.lock pyproject.toml
	@echo "Installing requirements-dev.lock into $(VENV) (a minute or two, once)"
	@$(PIP_INSTALL) --require-hashes -r requirements-dev.lock
	@$(PIP_INSTALL) --no-deps --no-build-isolation --editable .
	@touch $@ $(VENV)/.run

$(VENV)/.bench: $(VENV)/.dev requirements-bench.lock
	@echo "Installing requirements-bench.lock into $(VENV) (once)"
	@$(PIP_INSTALL) --require-hashes -r requirements-bench.lock
	@touch $@

$(VENV)/.release: $(VENV)/.dev requirements-release.lock
	@echo "Installing requirements-release.lock into $(VENV) (once)"
	@$(PIP_INSTALL) --require-hashes -r requirements-release.lock
	@touch $@

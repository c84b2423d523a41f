PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
VERSIONS := $(VENV)/versions.txt
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1
# processes that tests start read modules that were compiled before, also where a container says not to
unexport PYTHONDONTWRITEBYTECODE
# the theme's notice about MkDocs 2 says nothing about this build
export NO_MKDOCS_2_WARNING := 1

.PHONY: demo test pages campaigns kernels hashes lint docs bench prove wheel-demo clean

demo: $(VENV)/.core
	$(BIN)/autodb demo --out demo-out

test: $(VENV)/.dev
	$(BIN)/pytest -n 2 --dist worksteal -q

# what pages of docs print, and what pages show in a browser
pages: $(VENV)/.dev
	$(BIN)/pytest -n 2 --dist worksteal -q -m pages

# many draws of what the tests do with few; by hand
campaigns: $(VENV)/.dev
	$(BIN)/pytest -n 2 --dist worksteal -q -m campaign

# the numerical core once more, as other processors round it
kernels: $(VENV)/.dev
	$(BIN)/python -m tests.by_hand.kernels

# every file that pip takes is one whose checksum is known; torch comes from an index of its own, and
# atheris is of the fuzzing by hand
hashes: $(VERSIONS)
	set -e; away=$$(mktemp -d); trap 'rm -rf "$$away"' EXIT; \
	awk '/^[^ ]/ { left = /^(torch|atheris)==/ } !left' constraints.txt > "$$away/known.txt"; \
	$(BIN)/python -m pip download --quiet --require-hashes --no-deps --dest "$$away" -r "$$away/known.txt"; \
	echo "$$(ls "$$away" | wc -l) files, each with a known checksum"

lint: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/mkdocs build --quiet --strict

docs: $(VENV)/.dev
	$(BIN)/mkdocs build --quiet --strict
	@echo site/index.html

# the wheel, with nothing else of this checkout, in an environment of its own
wheel-demo: $(VENV)/.dev
	set -e; away=$$(mktemp -d); trap 'rm -rf "$$away"' EXIT; \
	$(BIN)/python -m build --wheel --no-isolation --outdir "$$away" . > "$$away/build.log"; \
	$(PYTHON) -m venv "$$away/venv"; \
	"$$away/venv/bin/python" -m pip install --quiet -c $(VERSIONS) "$$away"/*.whl; \
	cd "$$away" && venv/bin/autodb demo --out demo-out

bench: $(VENV)/.dev
	$(BIN)/python -m benchmarks

# every proof; killed in the middle it goes on where it was
prove: $(VENV)/.dev
	failed=0; \
	for name in published-axis axis-field stamps published-mill mill-forces mill-networks table faults faults-commands flips fleet axis-intervals calibration pairs pair-curve pair-laws pair-tables explain explain-outside explain-milling real force-tables day weeks; do \
	  $(BIN)/autodb prove $$name --out prove-out || failed=1; \
	done; exit $$failed

clean:
	rm -rf $(VENV) demo-out prove-out site

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

# pip takes no checkout where it is told checksums: the versions alone
$(VERSIONS): $(VENV)/bin/python constraints.txt
	sed -n 's/^\([^ #]*==[^ ]*\).*/\1/p' constraints.txt > $@

$(VENV)/.core: $(VERSIONS) pyproject.toml
	$(BIN)/python -m pip install --quiet -c $(VERSIONS) -e .
	touch $@

$(VENV)/.dev: $(VENV)/.core
	$(BIN)/python -m pip install --quiet -c $(VERSIONS) -e '.[dev]'
	touch $@

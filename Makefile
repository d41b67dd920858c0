# `make run` sets up all it needs in .venv and asks nothing of the machine but Python 3.11 (or later) and make. Some tests ask for more
# (README.md, More); without it they are skipped.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: help run check test thorough lint fmus bench torture mutants coverage figures reproduction flight pil prove trace references release format docs site authorities clean

# Each target with the comment above it.
help:
	@awk '/^#/ {said = said " " substr($$0, 3); next} /^[a-z]+:/ && said {sub(/:.*/, ""); printf "make %-13s%s\n", $$0, said} {said = ""}' Makefile

# The paper's first scenario, in an environment of its own: what README starts with.
run: $(VENV)/run
	@$(BIN)/orchestrate scenarios/paper_no_singularity.yaml

# A test that neither compiles, isolates, flies nor repeats for each block, page or tool has none of these markers (tests/conftest.py).
QUICK := not (compile or isolate or fly or thorough)
PYTEST := $(BIN)/pytest -n auto --dist worksteal

# A minute: what to run after each change.
check: lint
	$(PYTEST) -m '$(QUICK)'

# Seven minutes on two cores, ten where the FMUs are not built yet.
test: lint
	$(PYTEST) -m 'not thorough'

# The rest: the commands of all pages, the site, sanitizers, other tools, the wheel, builds and kits of all blocks. Some minutes.
thorough: $(VENV)/test
	$(PYTEST) -m thorough

# Format, lint, types and layers.
lint: $(VENV)/test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	git ls-files '*.c' '*.h' | xargs $(BIN)/clang-format --dry-run -Werror
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

# All FMUs, in out/fmus.
fmus: $(VENV)/run
	$(BIN)/orchestrate build
	$(BIN)/orchestrate build --flavour python

# The speed of loops, blocks and tools on this machine.
bench: $(VENV)/test
	$(BIN)/python -m tests.bench

# Random trials: what each counts, and exit status 1 where one finds an error. They take hours.
torture: $(VENV)/test
	for trial in tests/torture/[a-z]*.py; do $(BIN)/python -m tests.torture $$(basename $$trial .py) || exit; done

# Changes the code of some modules and prints the changes that no test sees; exit status 1 where there are any. About half an hour.
mutants: $(VENV)/test
	@$(call PACKAGES,'.[measures]')
	$(BIN)/python -m tests.mutants

# Branches of the blocks' C that the tests take: a table, and out/coverage/index.html. Needs gcc.
coverage: $(VENV)/test
	@$(call PACKAGES,'.[measures]')
	$(BIN)/python -m tests.branches

# The paper's figures, as docs/figures shows them.
figures: $(VENV)/test
	for scenario in paper_no_singularity paper_singularity; do \
	  $(BIN)/orchestrate scenarios/$$scenario.yaml --quiet --figures && cp results/$$scenario/figures/*.png docs/figures/ || exit; \
	done

# The paper's claims, examined: docs/evidence/reproduction.md and its figures; about five minutes on two cores.
reproduction: $(VENV)/test
	$(BIN)/python -m evidence reproduction

# Thousands of flights in SI units as campaigns: docs/evidence/flight.md and its figures; about an hour on two cores, goes on where it was stopped.
flight: $(VENV)/test
	$(BIN)/python -m evidence flight

# The flight code on an emulated Cortex-M7 (QEMU): docs/evidence/processor.md; about ten minutes.
pil: $(VENV)/test
	$(BIN)/python -m evidence processor

# The flight code's freedom from run-time errors, by Frama-C: docs/evidence/proofs.md; then the planted faults, which the proofs have to
# find, and MISRA's rules. Needs frama-c-base, cppcheck, clang-tidy and gcc-arm-none-eabi (Debian's names); where one is missing, the error says so.
prove: $(VENV)/test
	$(BIN)/python -m evidence proofs
	$(BIN)/python -m evidence planted

# Requirements with the code, tests, scenarios and proofs that name them: out/trace/trace.html, trace.csv and trace.reqif; an error where one lacks evidence.
trace: $(VENV)/test
	$(BIN)/python -m evidence trace

# The outside authorities' table, docs/evidence/verification.md.
authorities: $(VENV)/test
	$(BIN)/python -m tests.authorities
	$(BIN)/python -m evidence verification

# The wheel with its bills of materials and hashes, in dist/; refuses other versions of what has a say in the FMUs than the pinned.
release: $(VENV)/test
	$(BIN)/python -m release check
	rm -rf dist
	$(BIN)/python -m build --no-isolation
	$(BIN)/python -m release files dist

# Formats Python and C, and corrects what the linter can.
format: $(VENV)/test
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	git ls-files '*.c' '*.h' | xargs $(BIN)/clang-format -i

# What is committed and made from sources; tests fail where it drifts.
docs: $(VENV)/test
	$(BIN)/orchestrate schema > docs/scenario.schema.json
	$(BIN)/orchestrate schema --campaign > docs/campaign.schema.json
	$(BIN)/python -m tests.orchestration.wrong_inputs > tests/orchestration/wrong_inputs.md
	$(BIN)/python -m tests.orchestration.broken > tests/orchestration/broken.md
	$(BIN)/python -m docs.site.packages

# The reference data that our FMUs carry; needed where the behaviour of a block is meant to change.
references: $(VENV)/test
	for block in plant plant/judge plant/sensors estimator controller controller/planned controller/planned/wheels controller/wheels allocator allocator/bounded supervisor; do \
	  $(BIN)/orchestrate reference $$(echo $$block | tr / _) --out $$block/reference_data || exit; \
	done
	for block in plant plant/sensors estimator allocator/bounded; do \
	  $(BIN)/orchestrate reference $$(echo $$block | tr / _)_wheels --out $$block/reference_data_wheels || exit; \
	done

# The documentation as a web site, out/site/html/index.html; needs no network, neither to be built nor to be read.
site: $(VENV)/docs
	$(BIN)/python -m docs.site

# Removes the environment and all that was made.
clean:
	rm -rf $(VENV) out dist results

# Quietly, with a line before and the time after. uv installs in a third of the time of pip, which takes its place where uv cannot
# reach the packages: uv reads no configuration of pip.
INSTALL = begun=$$(date +%s) && $(1) && echo "installed in $$(( $$(date +%s) - begun )) s"
PACKAGES = { $(BIN)/uv pip install --quiet --system-certs --python $(BIN)/python --editable $(1) 2>/dev/null || $(PIP) --editable $(1); }
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile

$(VENV)/run: pyproject.toml
	@$(PYTHON) -c 'import sys; v = sys.version_info; v >= (3, 11) or sys.exit("attitude-cosim needs Python 3.11 or later; $(PYTHON) is Python %d.%d; remedy: make PYTHON=python3.12" % v[:2])'
	@echo "installing into $(VENV): half a minute, 650 MB ..."
	@# FMPy brings CMake along to compile FMUs from sources, and ppigrf, of which the coefficients are read, pandas: 170 MB, and not needed here.
	@$(call INSTALL,$(PYTHON) -m venv $(VENV) && { $(PIP) uv || true; } && $(call PACKAGES,'.[build]') && $(BIN)/python -m pip uninstall --quiet --yes cmake pandas)
	@touch $@

$(VENV)/docs: $(VENV)/run
	@$(call PACKAGES,'.[docs]')
	@touch $@

$(VENV)/test: $(VENV)/run
	@echo "installing the test tools into $(VENV): a minute or two ..."
	@$(call INSTALL,$(call PACKAGES,'.[test]'))
	@touch $@

# tedm: `make all` for the full report of the shipped sample, `make test` for the tests. Nothing else is needed first.

# The first Python of 3.11 to 3.13 that runs: a name on the path may belong to a version that is not there.
SUITABLE := import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))
ifeq ($(origin PYTHON),undefined)
PYTHON := $(shell for name in python3.11 python3.12 python3.13 python3; do \
	$$name -c '$(SUITABLE)' 2>/dev/null && command -v $$name && break; done)
endif
VENV ?= .venv
CONFIGS ?= configs
BUILD ?= build
TRADE ?= configs/trade/mounts.toml
ELEMENT_SIZE_MM ?=
MODEL_ARGUMENTS ?=
JOBS ?= 2
FUZZ_SEED ?= 2026
FUZZ_COUNT ?= 10000
FUZZ_LOG ?= fuzz.log
BEFORE ?=

$(foreach name,CONFIGS BUILD VENV,$(if $(word 2,$($(name))),$(error $(name) = '$($(name))': Make takes no names with blanks)))

BIN := $(VENV)/bin
PROJECT := $(CONFIGS)/tedm.toml
TEDM := $(BIN)/tedm
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt
RUN_STAMP := $(VENV)/.tedm-installed
DEV_STAMP := $(VENV)/.tedm-dev-installed
OPTIONS := -c $(PROJECT) -d $(BUILD)
CODE := $(shell find tedm_cli -name '*.py' -o -path '*/templates/*' -type f -o -path '*/page/*' -type f)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: FORCE help all stages trade test quick coverage check format docs reference bench fuzz faults sample-small clean distclean

help: ## Show this help
	@echo "make all      set up, run the whole chain on the sample, end in $(BUILD)/report.html (.pdf, .md), its annex, view.html"
	@echo "make stages   the same, each stage by a process of its own (make -j2 stages: two at once)"
	@echo "make trade    compare mounts of the sample (TRADE=FILE: other variants) in $(BUILD)/trade/trade.html"
	@echo "make test     set up and run the tests"
	@echo "make quick    run the tests of the pure rooms and of one chain: about a minute"
	@echo "make coverage run the tests, and tell how much of each room they run"
	@echo "make check    lint and types"
	@echo "make format   format the code"
	@echo "make docs     build the documentation as a site that needs no network, in $(BUILD)/site"
	@echo "make reference print docs/reference/ files.md, commands.md and configuration.md from the code"
	@echo "make bench    run the benchmarks in some ten minutes: tables, and JSON in $(BUILD)/benchmarks"
	@echo "make fuzz     judge $(FUZZ_COUNT) damaged inputs (FUZZ_SEED=$(FUZZ_SEED), FUZZ_COUNT): half an hour"
	@echo "make faults   kill every command, make all and tedm run at many moments, fill the disk, run chains at once: five minutes"
	@echo "make clean    remove $(BUILD); make distclean removes $(VENV) as well"
	@echo
	@echo "Variables: CONFIGS=$(CONFIGS) (folder with tedm.toml), BUILD=$(BUILD), ELEMENT_SIZE_MM (samples only; of the"
	@echo "first one 15, about 9,000 nodes, where left out; 5.5 gives 114,000), MODEL_ARGUMENTS (samples only; of the"
	@echo "first one '--mount pinned', hexapod, hexapod-x, bipods, clamped), JOBS=$(JOBS) (commands at once), PYTHON=$(PYTHON), VENV=$(VENV),"
	@echo "NASTRAN='nastran {deck} scr=yes batch=no' (your own solver instead of the embedded one)"

# pyNastran by a line of its own: on Python 3.13 its bound on numpy cannot be met, and need not be (see pyproject.toml).
$(RUN_STAMP): pyproject.toml constraints.txt
	@$(if $(PYTHON),$(PYTHON) -c '$(SUITABLE)' ||,) \
		{ echo "tedm needs Python 3.11, 3.12 or 3.13: name one, make PYTHON=/path/to/python3.12" >&2; exit 1; }
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(PIP) -e .
	$(PIP) --no-deps pynastran
	@touch $@

$(DEV_STAMP): $(RUN_STAMP)
	$(PIP) -e '.[dev]'
	@touch $@

test: $(DEV_STAMP) ## Run the tests on two cores
	$(BIN)/python -m pytest -n 2 --dist loadscope --no-loadscope-reorder -q

# The pure rooms and one whole chain: in a minute, whether a change is sound.
QUICK := gravity optics noise fem areas dynamics/test_dynamics_identities.py dynamics/test_dynamics_example.py \
	chain/test_chain_small.py

quick: $(DEV_STAMP)
	$(BIN)/python -m pytest -n 2 --dist loadscope -q -m 'not slow' $(addprefix tests/,$(QUICK))

coverage: $(DEV_STAMP)
	$(BIN)/python -m pytest -n 2 --dist loadscope --no-loadscope-reorder -q --cov --cov-report=
	$(BIN)/python tests/coverage_by_room.py

check: $(DEV_STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/mypy --config-file tests/mypy.ini tests
	$(BIN)/mypy --config-file tests/mypy.ini docs/hooks
	set -e; for file in $$(find tests -name conftest.py -o -name __main__.py); do $(BIN)/mypy --config-file tests/mypy.ini $$file; done

format: $(DEV_STAMP)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# Strict: a page that is not in mkdocs.yml, or a link that leads nowhere, is an error. The variable keeps the theme's news out.
docs: $(DEV_STAMP)
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet --strict --site-dir '$(abspath $(BUILD))/site'
	@echo "open $(BUILD)/site/index.html"

reference: $(RUN_STAMP)
	set -e; for page in contracts:files cli.reference:commands config.reference:configuration; do \
		$(BIN)/python -m tedm_cli.$${page%:*} > docs/reference/$${page#*:}.md; done

bench: $(DEV_STAMP)
	$(BIN)/python -m benchmarks --into '$(BUILD)/benchmarks' $(if $(BEFORE),--before '$(BEFORE)')

# Mutants that are not fine are in $(FUZZ_LOG), each with the line that judges it alone.
fuzz: $(DEV_STAMP)
	$(BIN)/python tests/fuzz --seed $(FUZZ_SEED) --count $(FUZZ_COUNT) --processes 2 --log $(FUZZ_LOG)

faults: $(DEV_STAMP)
	$(BIN)/python tests/faults

# The small model of the tests is kept in the repository with its results; this makes it again, to the byte.
sample-small: $(RUN_STAMP)
	$(BIN)/python sample_models/ltp_like.py --detail small --element-size-mm 1000 --layout configs/optics.toml -o sample_models/small/ltp_small.bdf
	$(TEDM) write-deck -c sample_models/small/tedm.toml
	$(TEDM) solve -c sample_models/small/tedm.toml

clean:
	rm -rf $(BUILD)

distclean: clean
	rm -rf $(VENV)

# --- the chain -------------------------------------------------------------------------------------------------------
# rules.mk tells what the project's configuration names: its model files and its cases.
ifneq ($(filter all stages $(BUILD)/%,$(MAKECMDGOALS)),)
include $(BUILD)/rules.mk
endif

# A layout beside the project file counts from when it is put there, though nothing may name it. A later version of the
# program may have variables that an older file lacks.
$(BUILD)/rules.mk: $(PROJECT) $(MODEL_TOML) $(OPTICS_TOML) $(wildcard $(CONFIGS)/optics.toml) $(CASES_TOML) \
		$(DYNAMICS_TOML) $(THERMAL_TOML) $(LOADS_TOML) $(GRAVITY_SOURCES) tedm_cli/stages/chain/make_rules.py | $(RUN_STAMP)
	$(TEDM) make-rules $(OPTIONS)

# A configuration file that the project no longer names may be gone.
$(MODEL_TOML) $(OPTICS_TOML) $(CASES_TOML) $(DYNAMICS_TOML) $(THERMAL_TOML) $(LOADS_TOML) $(GRAVITY_SOURCES) $(SUPERELEMENTS): ;

# Make tells by the rules below whether anything has to run; what has to, one `tedm run` does, with the commands of these
# rules in as few processes as there are jobs, so that libraries are loaded once for all of them. The models of samples are
# made first. This Make has seen to their arguments, and a rule that always runs would never be up to date.
GENERATED = $(addprefix $(BUILD)/,ltp.bdf ltp_areas.csv ltp_spacecraft.bdf ltp_spacecraft_areas.csv lisa.bdf lisa_areas.csv \
	thermal_nodes.csv thermal_conductors.csv thermal_powers.csv thermal_elements.csv)
THIS_MAKE := $(MAKE)
UP_TO_DATE = MAKEFLAGS= $(THIS_MAKE) -q -o $(BUILD)/model_arguments stages CONFIGS=$(CONFIGS) BUILD=$(BUILD) VENV=$(VENV) >/dev/null 2>&1
RUN = $(TEDM) run -v -j $(JOBS) $(OPTIONS) $(if $(NASTRAN),--nastran '$(subst ','\'',$(NASTRAN))')

all: $(filter $(GENERATED),$(MODEL_SOURCES) $(AREAS_CSV) $(THERMAL_SOURCES)) | $(RUN_STAMP)
	@$(UP_TO_DATE) || { echo "$(TEDM) run -v -j $(JOBS) $(OPTIONS)"; $(RUN); }
	@echo "open $(BUILD)/report.html and $(BUILD)/view.html"

# The same by the rules alone: each stage by a command, and so by a process, of its own.
stages: $(BUILD)/report.html $(BUILD)/view.html

# Variants of the sample by criteria; each has a build folder of its own in that of the trade.
trade: $(RUN_STAMP)
	$(TEDM) trade $(TRADE) -d $(BUILD) --scripts

# The shipped samples; a project that names another model never asks for them. Their benches are there without optics, too.
SCRIPT_ARGUMENTS = $(strip $(if $(ELEMENT_SIZE_MM),--element-size-mm $(ELEMENT_SIZE_MM)) $(MODEL_ARGUMENTS))
LTP_LAYOUT := $(or $(OPTICS_TOML),configs/optics.toml)
LISA_LAYOUT := $(or $(OPTICS_TOML),configs/lisa_like/optics.toml)

LTP_IMPORTED := $(addprefix sample_models/,deck_cards.py ltp_like_assumptions.py ltp_like_mounts.py \
	ltp_like_network.py ltp_like_solids.py ltp_like_spacecraft.py)

$(BUILD)/ltp.bdf: sample_models/ltp_like.py $(LTP_IMPORTED) $(LTP_LAYOUT) $(BUILD)/model_arguments | $(RUN_STAMP)
	$(BIN)/python $< $(SCRIPT_ARGUMENTS) --layout $(LTP_LAYOUT) -o $@

$(BUILD)/ltp_spacecraft.bdf: sample_models/ltp_like.py $(LTP_IMPORTED) $(LTP_LAYOUT) $(BUILD)/model_arguments | $(RUN_STAMP)
	$(BIN)/python $< --spacecraft $(SCRIPT_ARGUMENTS) --layout $(LTP_LAYOUT) -o $@

$(BUILD)/lisa.bdf: $(addprefix sample_models/,lisa_like.py lisa_like_layout.py deck_cards.py ltp_like_solids.py) \
		$(LISA_LAYOUT) $(BUILD)/model_arguments | $(RUN_STAMP)
	$(BIN)/python $< $(SCRIPT_ARGUMENTS) --layout $(LISA_LAYOUT) -o $@

$(BUILD)/ltp_areas.csv $(patsubst %,$(BUILD)/thermal_%.csv,nodes conductors powers elements): $(BUILD)/ltp.bdf ;
$(BUILD)/ltp_spacecraft_areas.csv: $(BUILD)/ltp_spacecraft.bdf ;
$(BUILD)/lisa_areas.csv: $(BUILD)/lisa.bdf ;

# Written anew only when the variables have other values than last time.
$(BUILD)/model_arguments: FORCE
	@mkdir -p $(@D)
	@echo '$(SCRIPT_ARGUMENTS)' | cmp -s - $@ || echo '$(SCRIPT_ARGUMENTS)' > $@

FORCE:

# MATRICES are sensitivity.h5 of a project with test masses, and optics.h5 of one with optics. make-rules writes halves
# anew when one of them comes or goes, and so is what is made of both; the same of the symmetry plane, which may follow the
# layout's frame, and of what compensation masses are tied to: of their CSV nothing else matters to the unit loads.
$(BUILD)/halves $(BUILD)/symmetry_plane $(BUILD)/ties: ;

ifneq ($(SOLVED_BY_TEDM),)
$(UNIT_DECK): $(MODEL_SOURCES) $(PROJECT) $(MODEL_TOML) $(CODE) | $(RUN_STAMP)
	$(TEDM) write-deck $(OPTIONS)

$(OP2): $(UNIT_DECK)
	$(TEDM) solve $(OPTIONS) $(if $(NASTRAN),--run '$(subst ','\'',$(NASTRAN))')
endif

$(BUILD)/unit_loads.h5: $(UNIT_DECK) $(OP2) $(AREAS_CSV) $(SUPERELEMENTS) $(PROJECT) $(MODEL_TOML) $(BUILD)/symmetry_plane $(BUILD)/ties $(CODE) | $(RUN_STAMP)
	$(TEDM) ingest $(OPTIONS)

$(BUILD)/distortion.h5: $(BUILD)/unit_loads.h5 $(OPTICS_TOML) $(BUILD)/halves
	$(TEDM) build-distortion $(OPTIONS)

$(BUILD)/sensitivity.h5: $(BUILD)/distortion.h5 $(MODEL_TOML) $(GRAVITY_SOURCES)
	$(TEDM) build-sensitivity $(OPTIONS)

$(BUILD)/optics.h5: $(BUILD)/distortion.h5 $(OPTICS_TOML) $(OPTICS_SOURCES)
	$(TEDM) build-optics $(OPTIONS)

# Of a project with test masses: what every temperature does to the outputs, or why this model has none of that here.
# CASE_ADJOINT is the same file, where the cases take something of it.
ifneq ($(ADJOINT),)
$(ADJOINT): $(UNIT_DECK) $(MATRICES) $(BUILD)/halves $(ADJOINT_OP2)
	$(TEDM) build-adjoint --or-say-why $(OPTIONS)
endif

# Of a project with a thermal model: its network, and what its nodes do to the outputs.
ifneq ($(THERMAL),)
$(THERMAL): $(THERMAL_TOML) $(THERMAL_SOURCES)
	$(TEDM) build-thermal $(OPTIONS)
endif

# TABLE_ of a case of the thermal network is that network's file, here and in closed loop.
# What other loads do is no part of `all`: nothing else is made of it.
ifneq ($(LOADS),)
$(LOADS): $(UNIT_DECK) $(MATRICES) $(BUILD)/halves $(LOADS_TOML)
	$(TEDM) build-loads $(OPTIONS)
endif

define CASE_RULE
$(1): $(MATRICES) $(CASE_ADJOINT) $(UNCERTAINTY_SOURCES) $(TABLE_$(notdir $(1))) $(BUILD)/halves $(CASES_TOML) $(EFFECTS) $(CASE_SOURCES) $(SPECTRA)
	$$(TEDM) run-case $$(CASE_ID_$(notdir $(1))) $$(OPTIONS)
endef
$(foreach file,$(CASE_FILES),$(eval $(call CASE_RULE,$(file))))

# Of a project with two test masses and optics: its loop, and every case in it.
$(BUILD)/dynamics.h5: $(MATRICES) $(EFFECTS) $(DYNAMICS_TOML) $(DYNAMICS_SOURCES)
	$(TEDM) build-dynamics $(OPTIONS)

define SIMULATION_RULE
$(1): $(BUILD)/dynamics.h5 $(CASE_ADJOINT) $(TABLE_$(notdir $(1))) $(CASES_TOML) $(EFFECTS) $(CASE_SOURCES) $(SPECTRA)
	$$(TEDM) simulate $$(CASE_ID_$(notdir $(1))) $$(OPTIONS)
endef
$(foreach file,$(SIMULATION_FILES),$(eval $(call SIMULATION_RULE,$(file))))

# Temperature series of the cases file: to the outputs, and through the loop.
define SERIES_RULE
$(1): $(MATRICES) $(BUILD)/halves $(CASES_TOML) $(EFFECTS) $(CASE_SOURCES) $(TABLE_$(notdir $(1)))
	$$(TEDM) run-series $$(SERIES_$(notdir $(1))) $$(OPTIONS)
endef
$(foreach file,$(SERIES_FILES),$(eval $(call SERIES_RULE,$(file))))

define SIMULATED_SERIES_RULE
$(1): $(BUILD)/dynamics.h5 $(CASES_TOML) $(EFFECTS) $(CASE_SOURCES) $(TABLE_$(notdir $(1)))
	$$(TEDM) simulate --series $$(SERIES_$(notdir $(1))) $$(OPTIONS)
endef
$(foreach file,$(SIMULATED_SERIES_FILES),$(eval $(call SIMULATED_SERIES_RULE,$(file))))

$(BUILD)/figures.stamp: $(ADJOINT) $(THERMAL) $(CASE_FILES) $(SIMULATION_FILES) $(SERIES_FILES) $(SIMULATED_SERIES_FILES)
	$(TEDM) plot $(OPTIONS)
	@touch $@

# Writes report.pdf and .md as well, and the annex of each.
$(BUILD)/report.html: $(BUILD)/figures.stamp $(PROJECT)
	$(TEDM) report $(OPTIONS)

$(BUILD)/view.html: $(CASE_FILES) $(SIMULATION_FILES) $(SERIES_FILES) $(wildcard $(BUILD)/series_*.h5)
	$(TEDM) view $(OPTIONS)

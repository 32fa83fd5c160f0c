# From a bare Debian 12 to a running program: `make help` says what there is.
# The work is done by CMake (CMakePresets.json) and scripts/; this file only puts the steps in order.

BUILD := build/release
JOBS ?= $(shell nproc)
PROGRAM := $(BUILD)/mimbre

.DEFAULT_GOAL := build
.PHONY: help packages test-tools configure build python docs docs-tools wheel sdist demo live page test bench bench-peers which-formulation lint format clean

help: ## Show this list
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1\t\2/p' $(firstword $(MAKEFILE_LIST)) | expand -t 20

packages: ## Install the Debian packages that are missing
	@scripts/install-packages

# What only the tests use: formatting, pages in a browser, meshes, a second solver, the site's C++ pages, instructions.
TEST_TOOLS := clang-format chromium gmsh calculix-ccx doxygen valgrind
test-tools: packages
ifdef LIGHT
	@echo "LIGHT is set: not installed are $(TEST_TOOLS)."
	@echo "Without them are skipped: the check of the formatting, pages in a browser (web.page, web.live, web.drive),"
	@echo "meshes made by Gmsh, comparisons with CalculiX, the documentation's site, and the count of instructions. The last lines list what was."
else
	@scripts/install-packages $(TEST_TOOLS)
endif

# One configuration for everything, so that nothing is compiled twice. Where CI is set, as continuous integration does,
# warnings are errors, in that build folder from then on: a call without CI leaves the configuration as it is.
configure: packages
	@cmake --preset release $(if $(CI),-DMIMBRE_WERROR=ON)

build: configure ## Build everything (the program: build/release/mimbre)
	@cmake --build $(BUILD) --parallel $(JOBS)

python: configure ## Install the Python package into build/python-env
	@scripts/python-env >/dev/null
	@CMAKE_BUILD_PARALLEL_LEVEL=$(JOBS) build/python-env/bin/python -m pip install --quiet --disable-pip-version-check --no-deps \
	  --no-build-isolation --force-reinstall .

docs: python docs-tools ## Make the documentation's site, build/docs/index.html
	@scripts/docs
	@echo "Made build/docs/index.html."

docs-tools:
	@scripts/install-packages doxygen

wheel: packages ## Make a wheel that is complete in itself in dist/, and use it in a bare system (as root)
	@JOBS=$(JOBS) scripts/wheel

sdist: packages ## Make a source distribution in dist/, and install it somewhere else
	@JOBS=$(JOBS) scripts/test-sdist

demo: configure ## Run a vehicle over stairs and make report.html, with plots and an animation
	@cmake --build $(BUILD) --parallel $(JOBS) --target mimbre_demo
	@mkdir -p results
	$(PROGRAM)-demo run examples/iltis/vehicle.yaml --output results/iltis.h5 --csv results/iltis.csv
	$(PROGRAM)-demo report results/iltis.h5 -o report.html
	@echo "Made report.html (plots, animation) from results/iltis.h5 (every channel; as a table: results/iltis.csv)."
	@echo "Open it in a browser:  xdg-open $(CURDIR)/report.html"
	@echo "Next:"
	@echo "  make                builds the rest of the program"
	@echo "  make live           drive the vehicle yourself, in the browser"
	@echo "  docs/tutorial.md    a model of your own: $(PROGRAM) run MODEL.yaml -o RUN.h5, then $(PROGRAM) report RUN.h5"
	@echo "  docs/gallery.md     robots, rotors, mechanisms, contact: pictures and the commands that make them"

page: packages ## Build `mimbre page`: the solver as WebAssembly (installs emscripten and a compiler), and the program with it
	@scripts/install-packages emscripten
	@JOBS=$(JOBS) scripts/wasm
	@$(MAKE) --no-print-directory configure
	@cmake --build $(BUILD) --parallel $(JOBS) --target mimbre_program
	@echo "Made build/wasm/mimbre.wasm, which the program has in it:  $(PROGRAM) page examples/iltis/drive.yaml -o drive.html"

live: configure ## Drive a vehicle in the browser
	@cmake --build $(BUILD) --parallel $(JOBS) --target mimbre_program
	$(PROGRAM) live examples/iltis/drive.yaml --open

# The checks of the sources come before the tests, so that the last lines are the summary of ctest.
test: test-tools build ## Build everything and run all checks and tests (LIGHT=1: without Chromium, Gmsh and CalculiX)
	@$(MAKE) --no-print-directory python
	@scripts/check-format
	@scripts/check-words
	@scripts/check-includes
	@scripts/check-elementary
	@ctest --test-dir $(BUILD) --output-on-failure --parallel $(JOBS)

bench: configure ## Run the benchmarks
	@cmake --build $(BUILD) --parallel $(JOBS) --target mimbre_bench
	$(BUILD)/bench/mimbre_bench

which-formulation: build ## Make docs/which-formulation.md anew: all ways to bend on the same models
	python3 bench/which_formulation.py --program $(PROGRAM)

bench-peers: configure ## Compare with Exudyn, MuJoCo, Pinocchio, Drake (CASES="chain-10 ur5": these only)
	@cmake --build $(BUILD) --parallel $(JOBS) --target mimbre_program
	@scripts/peers-env
	build/peers-env/bin/python bench/peers/compare.py --program $(PROGRAM) $(CASES)

lint: ## Check the formatting and run clang-tidy over all sources
	@scripts/install-packages clang-format clang-tidy
	@cmake --preset debug
	@scripts/check-format
	@scripts/lint build/debug

format: ## Format all C++ files
	@scripts/install-packages clang-format
	@scripts/sources '*.h' '*.cpp' | xargs --null clang-format -i

clean: ## Remove what was built (results stay)
	rm -rf build web/dist

# Everything happens in .venv; nothing is fetched from anywhere but the package index.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
DEMO := kerb-discover
# Two workers: the tests that plan are bound by memory as much as by cores.
WORKERS ?= 2

.DEFAULT_GOAL := help
.PHONY: help demo test lint docs blocks links tables bench gallery clean

help: ## Say what there is.
	@grep -hE '^[a-z]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## (.*)/  make \1\t\2/' | expand -t 16

demo: $(READY) ## Find how CENTAURO drives to a kerb, steps up and drives on; draw it; execute it in MuJoCo. Writes out/.
	@mkdir -p out
	@$(BIN)/rollgait plan $(DEMO) --out out/$(DEMO).npz
	@$(BIN)/rollgait plot out/$(DEMO).npz --out out/$(DEMO)-figures
	@echo
	@$(BIN)/rollgait track out/$(DEMO).npz --out out/$(DEMO).joints.npz
	@echo
	@$(BIN)/rollgait simulate out/$(DEMO).joints.npz
	@echo
	@echo "Type next:"
	@echo "  source $(BIN)/activate"
	@printf "  %-40s %s\n" \
	  "rollgait check out/$(DEMO).npz" "show its certificate again" \
	  "rollgait run wheeled" "the whole chain, with a report page" \
	  "rollgait scenarios" "see the other motions" \
	  "rollgait show $(DEMO) > my.yaml" "start one of your own"

test: $(READY) ## Run the tests.
	@$(BIN)/python -m pytest -q -n $(WORKERS) --dist loadfile

lint: $(READY) ## Check style, types (those of README, docs and examples, too) and the tables in docs/.
	@$(BIN)/ruff check
	@$(BIN)/ruff format --check --quiet || { echo "run: $(BIN)/ruff format"; exit 1; }
	@$(BIN)/mypy
	@$(BIN)/python tools/check_types.py
	@$(BIN)/python tools/field_tables.py --check
	@$(BIN)/python tools/package_page.py --check

docs: $(READY) ## Build the documentation into build/docs and check its links; open build/docs/index.html.
	@$(BIN)/python -m sphinx -W --keep-going -q -j auto -d build/docs-cache docs build/docs
	@$(BIN)/python tools/site_links.py build/docs

blocks: $(READY) ## Run every command and code block of README.md and docs/, page by page.
	@$(BIN)/python tools/page_blocks.py README.md docs

links: $(READY) ## Ask the network whether the addresses in docs/ still answer. Not run by .ci/run.
	@$(BIN)/python -m sphinx -q -b linkcheck -d build/docs-cache docs build/links

tables: $(READY) ## Write the tables in docs/ anew from the code, and PACKAGE.md from README.md.
	@$(BIN)/python tools/field_tables.py
	@$(BIN)/python tools/package_page.py

bench: $(READY) ## Run the benchmarks.
	@for file in benchmarks/*.py; do echo "$$file"; $(BIN)/python $$file || exit 1; done

gallery: $(READY) ## Build docs/gallery: pictures, recordings and numbers of the motions.
	@$(BIN)/python tools/gallery.py

clean: ## Remove all that make has made.
	rm -rf $(VENV) out build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis src/*.egg-info

$(READY): pyproject.toml tools/make_venv.sh
	@tools/make_venv.sh $(PYTHON) $(VENV)
	@touch $@

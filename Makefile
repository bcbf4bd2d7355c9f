# Every target does all the set-up it needs (see .ci/setup) and says so in one line when there is none to do.
bin := .venv/bin
preview := out/preview
native_presets := release dev tsan
cpp_files = $(shell find native tests/native -name '*.h' -o -name '*.cpp')

.DEFAULT_GOAL := help
.PHONY: help preview test addon bench format lint native python setup-preview setup-test setup-bench clean

help: ## this list
	@sed -n 's/^\([a-z]*\):.*## /  make \1\t/p' Makefile | expand -t 18

preview: setup-preview ## set up, then render blend_files/explosion.blend to frames, a movie and statistics
	@$(bin)/regraft render blend_files/explosion.blend --output $(preview) --resolution 960x540 \
	  --movie $(preview)/explosion.mp4 --statistics $(preview)/explosion.jsonl

test: lint native python ## set up, then all checks: style, types, native tests and sanitizers, Python and four Blenders

lint: setup-test ## ruff, mypy and clang-format, changing nothing
	$(bin)/ruff check .
	$(bin)/ruff format --check .
	$(bin)/mypy
	@clang-format --dry-run -Werror $(cpp_files)

format: setup-test ## rewrite Python and C++ in the project's style
	$(bin)/ruff check --fix .
	$(bin)/ruff format .
	@clang-format -i $(cpp_files)

native: setup-test ## the native tests: optimised, address and undefined-behaviour, threads
	@for preset in $(native_presets); do \
	  echo "== native tests: $$preset" && cmake --preset $$preset -DREGRAFT_BUILD_PYTHON=OFF >build/configure-$$preset.log && \
	  cmake --build --preset $$preset && ctest --preset $$preset --progress || exit 1; \
	done

python: setup-test addon ## the Python tests, in every supported Blender
	REGRAFT_ALL_BLENDERS=1 $(bin)/pytest -n 2 --dist loadscope

addon: setup-preview ## build both add-on packages into dist/
	@$(bin)/python addon/build_zips.py --wheel build/wheels/regraft-*.whl --output dist

bench: setup-bench ## the native benchmarks
	@cmake --preset bench >build/configure-bench.log && cmake --build --preset bench && build/bench/native/bench/regraft_bench

setup-preview setup-test setup-bench: setup-%:
	@.ci/setup $*

clean: ## remove everything built, but not the environments
	rm -rf build dist out

# make demo       the three jobs on real data, headless: build/demo/report.md, pictures, a .blend
# make test       every test: core, binding, add-on logic, and inside real Blenders
# make lint       rustfmt, clippy, ruff
# make extension  dist/lissom-<version>-<platform>.zip, for Blender's "Install from Disk"
# make bench      measured against other tools
#
# Needs Rust, make and Python 3.11; everything else goes into .venv/ and build/ of this folder.

PYTHON ?= python3.11
# Blender 5.2 as a module needs Python 3.13; its tests are left out, and say so, where there is none.
PYTHON313 ?= $(firstword $(shell for p in python3.13 $$HOME/.pyenv/versions/3.13*/bin/python3.13; do \
	"$$p" -c '' 2>/dev/null && echo "$$p"; done))
LISSOM_DATA ?= $(abspath ../shared/data)
export LISSOM_DATA

RUST := $(shell find rust -name '*.rs' -o -name 'Cargo.toml') Cargo.toml Cargo.lock pyproject.toml
TOOLS := .venv/tools/ready
WHEEL := dist/wheel.stamp

.PHONY: all demo test test-rust test-native test-blender lint extension bench clean
all: extension

# --- tools and wheel -------------------------------------------------------------------------------

$(TOOLS):
	$(PYTHON) -m venv .venv/tools
	.venv/tools/bin/python -m pip install -q --disable-pip-version-check \
		'maturin>=1.9,<2' 'numpy>=1.26' 'pytest>=8' 'ruff>=0.8'
	touch $@

$(WHEEL): $(TOOLS) $(RUST) README.md rust/lissom-py/lissom.pyi
	rm -f dist/*.whl
	.venv/tools/bin/maturin build --release --locked --interpreter .venv/tools/bin/python -o dist
	.venv/tools/bin/python -m pip install -q --disable-pip-version-check --force-reinstall --no-deps dist/*.whl
	touch $@


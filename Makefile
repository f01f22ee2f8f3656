# make demo       the three jobs on real data, headless: build/demo/report.md, pictures, a .blend
# make gallery    the thesis's and the survey's poses by all methods; the latter needs LISSOM_DATA
# make test       every test: core, binding, add-on logic, and inside real Blenders
# make lint       rustfmt, clippy, ruff, mypy and its stubtest
# make audit      licences, known flaws and doubles of what we take in, and the workflows; needs cargo-deny
# make bench      measured against libigl and Blender's Laplacian Deform; needs LISSOM_DATA
# make fuzz       random meshes and options through every call, until something fails or one stops it
# make docs       the manual as a site: .venv/docs/site/index.html
# make extension  dist/lissom-<version>-<platform>.zip, for Blender's "Install from Disk"
#
# Needs Rust, make and Python 3.11; everything else goes into .venv/ and build/ of this folder.

PYTHON ?= python3.11
# Blender 5.2 as a module needs Python 3.13; its tests are left out, and say so, where there is none.
PYTHON313 ?= $(firstword $(shell for p in python3.13 $$HOME/.pyenv/versions/3.13*/bin/python3.13; do \
	"$$p" -c '' 2>/dev/null && echo "$$p"; done))

RUST := $(shell find rust -name '*.rs' -o -name 'Cargo.toml') Cargo.toml Cargo.lock pyproject.toml
PYTHON_SOURCE := $(shell find python -name '*.py' -o -name '*.pyi' -o -name py.typed)
TOOLS := .venv/tools/ready
WHEEL := dist/wheel.stamp

.SECONDARY:
.PHONY: all demo gallery test test-rust test-native test-blender lint audit extension bench fuzz docs clean
all: extension

# --- tools, wheel, Blenders -------------------------------------------------------------------------

PIP_INSTALL := -m pip install -q --disable-pip-version-check

$(TOOLS): Makefile
	$(PYTHON) -m venv .venv/tools
	.venv/tools/bin/python $(PIP_INSTALL) 'maturin>=1.9,<2' 'numpy>=1.26' 'pytest>=8,<10' 'ruff>=0.8,<1' \
		'mypy>=1.15,<2' 'hypothesis>=6,<7' 'grimp>=3,<4'
	touch $@

$(WHEEL): $(TOOLS) $(RUST) $(PYTHON_SOURCE) LICENSE THIRD_PARTY.txt
	rm -f dist/*.whl
	.venv/tools/bin/maturin build --release --locked --interpreter .venv/tools/bin/python -o dist
	.venv/tools/bin/python $(PIP_INSTALL) --force-reinstall --no-deps dist/*.whl
	touch $@

# One environment per Blender: .venv/bpy-4.2 and so on. It is fetched while the wheel is built.
.venv/bpy-%/blender:
	$(if $(filter 5.2,$*),$(PYTHON313),$(PYTHON)) -m venv .venv/bpy-$*
	.venv/bpy-$*/bin/python $(PIP_INSTALL) 'bpy==$*.*' 'pytest>=8,<10' 'pillow>=11'
	touch $@

.venv/bpy-%/ready: .venv/bpy-%/blender $(WHEEL)
	.venv/bpy-$*/bin/python $(PIP_INSTALL) --force-reinstall --no-deps dist/*.whl
	.venv/bpy-$*/bin/python -c 'import bpy' || { echo; \
		echo "Blender as a module needs these system libraries (Debian's names); .ci/libraries installs them:"; \
		sed -n 's/^LIBRARIES=//p' .ci/libraries; exit 1; }
	touch $@

# --- the jobs ---------------------------------------------------------------------------------------

demo: .venv/bpy-5.0/ready
	.venv/bpy-5.0/bin/python demo/run.py --out build/demo

gallery: .venv/bpy-5.0/ready
	.venv/bpy-5.0/bin/python demo/gallery.py --out build/gallery

test: test-native test-blender test-rust

test-rust:
	cargo test --release --locked -q -p lissom

test-native: $(WHEEL)
	.venv/tools/bin/python -m pytest --durations=15 tests/native tests/addon_core

fuzz: $(WHEEL)
	while PROPTEST_RNG_SEED=$$(date +%s) PROPTEST_CASES=100000 cargo test --release --locked -q -p lissom --test all random \
		&& .venv/tools/bin/python -m pytest -q --hypothesis-profile=fuzz tests/native/test_random_*.py; do :; done

# The oldest and the newest that is supported; make test-blender-5.0 is one between.
BLENDERS := 4.2 $(if $(PYTHON313),5.2,5.0)
test-blender: $(BLENDERS:%=test-blender-%)
	@$(if $(PYTHON313),true,echo "LEFT OUT: Blender 5.2, which needs Python 3.13; set PYTHON313=/path/to/python3.13")

test-blender-%: .venv/bpy-%/ready
	.venv/bpy-$*/bin/python -m pytest --durations=15 tests/blender

lint: $(WHEEL)
	cargo fmt --all --check
	cargo clippy --release --locked --all-targets -- -D warnings
	.venv/tools/bin/ruff check .
	.venv/tools/bin/ruff format --check .
	.venv/tools/bin/mypy --strict --python-executable .venv/tools/bin/python python/lissom
	.venv/tools/bin/python -m mypy.stubtest lissom
	.venv/tools/bin/python tools/licences.py --check

audit: $(TOOLS) .venv/audit/ready
	cargo deny check
	.venv/audit/bin/pip-audit --progress-spinner off --path $(wildcard .venv/tools/lib/python*/site-packages)
	.venv/audit/bin/zizmor --offline --quiet .github

.venv/audit/ready: Makefile
	$(PYTHON) -m venv .venv/audit
	.venv/audit/bin/python $(PIP_INSTALL) 'pip-audit>=2,<3' 'zizmor>=1,<2'
	touch $@

# Strict: dead links and pages that nothing leads to are errors.
docs: .venv/docs/ready
	PATH="$(CURDIR)/.venv/docs/bin:$$PATH" NO_MKDOCS_2_WARNING=1 mkdocs build --strict --quiet
	@echo .venv/docs/site/index.html

.venv/docs/ready: Makefile
	$(PYTHON) -m venv .venv/docs
	.venv/docs/bin/python $(PIP_INSTALL) 'mkdocs-material>=9.6,<10' 'mkdocstrings[python]>=1,<2' 'ruff>=0.8,<1'
	touch $@

extension: $(WHEEL)
	.venv/tools/bin/python tools/build_extension.py

bench: $(WHEEL)
	test -x .venv/bench/bin/python || $(PYTHON) -m venv .venv/bench
	# 5.0 crashes in its own Laplacian Deform.
	.venv/bench/bin/python $(PIP_INSTALL) 'bpy==4.2.*' 'libigl==2.6.*' 'pytest>=8,<10'
	.venv/bench/bin/python $(PIP_INSTALL) --force-reinstall --no-deps dist/*.whl
	.venv/bench/bin/python bench/pose.py --out build/bench
	.venv/bench/bin/python bench/live.py
	.venv/bench/bin/python bench/inbetween.py
	.venv/bench/bin/python bench/transfer.py
	.venv/bench/bin/python bench/fit.py
	.venv/bench/bin/python bench/face.py
	.venv/bench/bin/python bench/learn.py

clean:
	rm -rf .venv build dist target

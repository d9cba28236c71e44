# Both worlds at once: the page in viewer/ (Node.js 20) and the server (Rust). `make run` and `make test` are all one needs.
.PHONY: run view test book figures fuzz soak attack golden loom wheel package dist release check

# Expanded only where something has to be built with it.
npm = $(or $(shell command -v npm 2>/dev/null),$(error npm is missing (it is a part of Node.js): \
	`cargo run --release -- serve` does all but the page))

# With the folders: the time of one changes when a file in it is added or removed.
page_sources := $(shell find viewer/src viewer/public) viewer/index.html viewer/package.json viewer/tsconfig.json \
	viewer/vite.config.ts

# A server that one can look at.
run: view
	cargo run --release -- serve

# The page, which the next build of the server embeds: viewer/dist is touched only where the page differs, as the server
# is linked anew after that.
view: target/page/index.html
	@diff -qr target/page viewer/dist/page >/dev/null 2>&1 || \
		(rm -rf viewer/dist/page && cp -r target/page viewer/dist/page)

target/page/index.html: viewer/node_modules/.package-lock.json $(page_sources)
	cd viewer && $(npm) run build -- --outDir ../target/page
	cp viewer/node_modules/@fontsource-variable/inter/LICENSE target/page/assets/inter-licence.txt

# Everything that is tested, the page in a real browser (chromium) too.
test: view
	cargo test
	cd viewer && USARSIM=$(CURDIR)/target/debug/usarsim npm test

# The book as pages: target/book/index.html. mdBook is built once, into target/tools.
book: target/tools/bin/mdbook
	target/tools/bin/mdbook build docs

target/tools/bin/mdbook:
	cargo install mdbook --version 0.5.4 --debug --locked --no-default-features --features search --root target/tools

# Random inputs guided by coverage, for everything that a stranger can send: docs/reliability.md. Needs a C++ compiler.
# `make fuzz SECONDS=600 TARGET=world`, `make fuzz JOBS=2`.
SECONDS = 60
JOBS = 1
TARGET =
fuzz: target/tools/bin/cargo-fuzz
	fuzz/run $(SECONDS) $(JOBS) $(TARGET)

target/tools/bin/cargo-fuzz:
	cargo install cargo-fuzz --version 0.13.2 --locked --root target/tools

# A server and a world that clients come to and leave for a simulated day, and robots by the ten thousand: docs/reliability.md.
# `make soak HOURS=1 LEAVINGS=5000`. `cargo test` runs the same for a minute.
HOURS = 24
LEAVINGS = 65536
soak:
	USARSIM_SOAK_HOURS=$(HOURS) USARSIM_SOAK_LEAVINGS=$(LEAVINGS) \
		cargo test --release -p system-tests -p usarsim --test soak -- --nocapture --test-threads=1

# Ten minutes of 64 hostile clients, made from the recordings that USARSIM_CAPTURES names, beside an honest one.
attack:
	@[ -n "$$USARSIM_CAPTURES" ] || { echo "USARSIM_CAPTURES has to name the folder of the recordings" >&2; exit 64; }
	USARSIM_ATTACK_SECONDS=600 cargo test --release -p usarsim --test all attack -- --nocapture --include-ignored

# Fixed worlds in WebAssembly, with the digests that `cargo test` wants of them on this machine.
golden:
	tests/golden/run

# Every order in which the threads that share an outbox can meet.
loom:
	cargo test --quiet --package outbox --features loom

# The Python package as a wheel in target/dist, tested in clean environments of Python 3.10 and 3.13.
wheel: view
	packaging/wheel
	tests/python target/dist/*.whl

# The libraries as a registry takes them, each built from its package: docs/libraries.md. `make package VERIFY=--no-verify` builds none.
VERIFY =
LIBRARIES = articulated base-motion friction gamebots-client gamebots-proto kinematics scene sim-core usarsim-names
package:
	cargo package --locked $(VERIFY) $(LIBRARIES:%=--package %)

# What is given away, with SHA256SUMS in target/dist: docs/install.md. `packaging/try` tries it.
# Only for one processor: `make dist TARGETS=x86_64-unknown-linux-musl`.
TARGETS =
dist: view
	packaging/dist $(TARGETS)

# What is tried before a release, beside `make check`: what `make run` starts in the browser, what `make dist` makes, the Python package
# with Stable-Baselines3 and its types, an installation from source, and the book's pages.
release: dist package book
	cargo build --release --bin usarsim
	tests/interop/run
	cargo test --release -p usarsim --test all figures
	USARSIM=target/release/usarsim target/interop/venv/bin/python bench/validation.py --check docs/validation.md
	target/interop/venv/bin/python bench/compare.py --seconds 1 --repeat 1 --out target/interop/comparison.md
	cd viewer && npm test
	packaging/try
	tests/python target/dist/*.whl
	cargo install --quiet --locked --path crates/usarsim --root target/installed
	target/installed/bin/usarsim snapshot --map arena --robot P3AT --size 64x48 --out target/installed/p3at.png

# What CI runs.
check:
	.ci/run

# Every measured number that README.md and docs show, made anew: a quarter of an hour on a machine that does nothing else.
figures: target/interop/venv/bin/python target/interop/older/bin/python wheel
	UPDATE_FIGURES=1 cargo test --workspace --lib the_page_has_the_types_of
	UPDATE_FIGURES=1 cargo test --release -p usarsim --test all figures -- --nocapture
	$< -m pip install --quiet --requirement tests/interop/requirements.txt
	$< bench/validation.py
	$< bench/compare.py --beside target/interop/older/bin/python --out docs/comparison.md
	$< -m pip install --quiet --force-reinstall target/dist/*.whl gymnasium
	$< bench/learning.py --out docs/howto-learning.md

target/interop/venv/bin/python:
	python3 -m venv target/interop/venv

# A MuJoCo of before 4.0.0, whose sparse factorisation is wrong.
target/interop/older/bin/python:
	python3 -m venv target/interop/older
	$@ -m pip install --quiet mujoco==3.17.0 numpy

viewer/node_modules/.package-lock.json: viewer/package-lock.json
	cd viewer && $(npm) ci --no-fund --no-audit

# Both worlds at once: the page in viewer/ (Node.js 20) and the server (Rust). `make run` and `make test` are all one needs.
.PHONY: run view test book check

# A server that one can look at.
run: view
	cargo run --release -- serve

# The page, which the next build of the server embeds.
view: viewer/node_modules/.package-lock.json
	cd viewer && npm run build

# Everything that is tested, the page in a real browser (chromium) too.
test: view
	cargo test
	cargo build --release
	cd viewer && npm test

# The book as pages: target/book/index.html. mdBook is built once, into target/tools.
book: target/tools/bin/mdbook
	target/tools/bin/mdbook build docs

target/tools/bin/mdbook:
	cargo install mdbook --version 0.5.4 --locked --no-default-features --features search --root target/tools

# What CI runs.
check:
	.ci/run

viewer/node_modules/.package-lock.json: viewer/package-lock.json
	cd viewer && npm ci --no-fund --no-audit

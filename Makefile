# Both worlds at once: the page in viewer/ (Node.js 20) and the server (Rust). `make run` and `make test` are all one needs.
.PHONY: run view test check

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

# What CI runs.
check:
	.ci/run

viewer/node_modules/.package-lock.json: viewer/package-lock.json
	cd viewer && npm ci --no-fund --no-audit

# Daily commands; continuous integration runs the same.

# Format, lints, documentation: the fast checks.
check:
    cargo fmt --all --check
    cargo clippy --release --workspace --all-targets --locked -- -D warnings
    cargo check --release --locked -p robhaz --no-default-features
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked

# All tests, in the profile that runs use, so that dependencies are built once.
test:
    cargo test --release

# Timings, as ratios within one run.
bench:
    cargo bench --workspace --bench robhaz

# The measured tables of docs/measurements: all, or the named pages; `--seeds N` before the names makes them shorter.
measure *pages:
    python3 docs/measurements/measure.py {{ pages }}

# The paper's main scene, with its figures in runs/smooth/figures.
figures:
    cargo run --release -- run scenes/smooth.toml --force

# All of continuous integration.
ci:
    bash .ci/run

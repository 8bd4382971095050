#!/bin/sh
# Leaves target/explorer/standfast.wasm, the core as WebAssembly for pages: `make explorer`.
#
# Rust's library for WebAssembly comes from rustup, or, where there is none of it (STANDFAST_RUST_WEB=debian: in any case), from the
# packages of Debian or Ubuntu, which are unpacked under target/ and not installed.
set -eu
cd "$(dirname "$0")/../.."
TARGET=wasm32-unknown-unknown
PACKAGES="rustc-web libstd-rust-web-dev rust-web-src lld-19"

has_target() {
	test -n "$(find "$(rustc --print sysroot)/lib/rustlib/$TARGET/lib" -name 'libcore-*.rlib' 2>/dev/null)"
}

from_rustup() {
	test "${STANDFAST_RUST_WEB:-}" != debian || return 1
	has_target && return
	command -v rustup > /dev/null && rustup target add $TARGET && has_target
}

# The packages, those of their dependencies that bring the compiler's own libraries, and a folder of all of it.
from_debian() {
	command -v apt-get > /dev/null && command -v dpkg-deb > /dev/null || return 1
	root=$PWD/target/rust-web
	if ! test -e "$root/whole"; then
		rm -rf "$root" && mkdir -p "$root"
		needed=$(apt-cache depends --recurse --no-recommends --no-suggests --no-conflicts --no-breaks --no-replaces --no-enhances \
			$PACKAGES | grep -E '^(libstd-rust-web|libllvm)' | sort -u)
		(cd "$root" && apt-get download $PACKAGES $needed) || return 1
		for package in "$root"/*.deb; do
			dpkg-deb -x "$package" "$root" && rm "$package"
		done
		touch "$root/whole"
	fi
	export RUSTC="$root/usr/bin/rustc"
	LD_LIBRARY_PATH=$(find "$root/usr/lib" -name 'lib*.so*' -exec dirname {} + | sort -u | paste -sd :)
	export LD_LIBRARY_PATH
	export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER="$root/usr/bin/wasm-ld-19"
	# Debian has the library as source for Cargo to build, which stable Rust only does when told that it may.
	export RUSTC_BOOTSTRAP=1
	BUILD_STD="-Zbuild-std=std,panic_abort"
}

BUILD_STD=
if ! from_rustup && ! from_debian; then
	echo "make explorer needs Rust's library for WebAssembly: rustup target add $TARGET, or apt-get with $PACKAGES" >&2
	exit 1
fi
cargo build --manifest-path crates/wasm/Cargo.toml --target-dir target --release --target $TARGET $BUILD_STD
mkdir -p target/explorer
cp target/$TARGET/release/standfast_wasm.wasm target/explorer/standfast.wasm
echo "target/explorer/standfast.wasm: $(wc -c < target/explorer/standfast.wasm) bytes, gzipped $(gzip -9 -c target/explorer/standfast.wasm | wc -c)"

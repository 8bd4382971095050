//! The core as WebAssembly: [`standfast::ask`] for pages, without imports and without a generated interface.
//!
//! Texts cross as bytes of UTF-8 in the memory of the module. The page asks `alloc` for room, writes the question there, calls `ask`, reads
//! the answer, and gives both back by `free`: `engine.js` of the pages does that. A panic traps; the module has to be loaded anew afterwards.

#![deny(unsafe_op_in_unsafe_fn)]

use std::ptr::slice_from_raw_parts_mut;

/// Bytes before an answer: its length without them, little-endian.
const PREFIX: usize = 4;

/// `len` bytes of memory, all 0, until [`free`].
// On other systems the name would replace a function of the C library, as would `free`.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub extern "C" fn alloc(len: usize) -> *mut u8 {
    leaked(vec![0; len])
}

/// Gives back what [`alloc`] or [`ask`] has returned.
///
/// # Safety
///
/// `ptr` comes from [`alloc`] with the same `len`, or from [`ask`] with `len` = 4 + the length of the answer, and is not used again.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub unsafe extern "C" fn free(ptr: *mut u8, len: usize) {
    // SAFETY: `leaked` has made `ptr` of a box of `len` bytes, and the caller gives it back once.
    drop(unsafe { Box::from_raw(slice_from_raw_parts_mut(ptr, len)) });
}

/// The answer to the question in the `len` bytes at `ptr`: four bytes with the length of the answer, and the answer.
///
/// # Safety
///
/// `ptr` comes from [`alloc`] with the same `len`, and has not been given back.
#[cfg_attr(target_family = "wasm", unsafe(no_mangle))]
pub unsafe extern "C" fn ask(ptr: *const u8, len: usize) -> *mut u8 {
    // SAFETY: `alloc` has returned `ptr` for `len` bytes, all set to 0 at first, and nobody writes to them during this call.
    let question = unsafe { std::slice::from_raw_parts(ptr, len) };
    let answer = standfast::ask(&String::from_utf8_lossy(question));
    let length = u32::try_from(answer.len()).expect("an answer is shorter than 4 GiB");
    let mut bytes = Vec::with_capacity(PREFIX + answer.len());
    bytes.extend(length.to_le_bytes());
    bytes.extend(answer.into_bytes());
    leaked(bytes)
}

/// The bytes without an owner: a box of them, whose length is that of the vector.
fn leaked(bytes: Vec<u8>) -> *mut u8 {
    Box::into_raw(bytes.into_boxed_slice()).cast()
}

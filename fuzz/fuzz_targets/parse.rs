//! Any bytes as a scene file: `cargo +nightly fuzz run parse`.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../parse_body.rs"]
mod parse_body;

fuzz_target!(|text: &[u8]| parse_body::parse_and_write(text));

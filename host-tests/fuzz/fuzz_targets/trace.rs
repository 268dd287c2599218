//! Fuzz target `trace`: `attack::fuzzed::trace` on any bytes.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attack::fuzzed::trace(bytes));

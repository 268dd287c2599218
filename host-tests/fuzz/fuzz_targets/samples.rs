//! Fuzz target `samples`: `attack::fuzzed::samples` on any bytes.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attack::fuzzed::samples(bytes));

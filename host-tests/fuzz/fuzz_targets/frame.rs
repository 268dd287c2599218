//! Fuzz target `frame`: `attack::fuzzed::frame` on any bytes.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attack::fuzzed::frame(bytes));

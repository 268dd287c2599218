//! Fuzz target `configuration`: `attack::fuzzed::configuration` on any bytes.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attack::fuzzed::configuration(bytes));

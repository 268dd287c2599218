//! Fuzz target `message`: `attack::fuzzed::message` on any bytes.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attack::fuzzed::message(bytes));

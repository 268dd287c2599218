//! Fuzz target `stored_records`: `attack::fuzzed::stored_records` on any bytes.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attack::fuzzed::stored_records(bytes));

//! Fuzz target `flights`: `attack::fuzzed::flights` on any bytes.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attack::fuzzed::flights(bytes));

//! Fuzz target `rm3100`: `attack::fuzzed::rm3100` on any bytes.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attack::fuzzed::rm3100(bytes));

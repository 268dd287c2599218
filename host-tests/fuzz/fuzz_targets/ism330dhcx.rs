//! Fuzz target `ism330dhcx`: `attack::fuzzed::ism330dhcx` on any bytes.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attack::fuzzed::ism330dhcx(bytes));

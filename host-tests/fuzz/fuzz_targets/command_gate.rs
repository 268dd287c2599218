//! Fuzz target `command_gate`: `attack::fuzzed::command_gate` on any bytes.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| attack::fuzzed::command_gate(bytes));

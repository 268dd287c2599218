#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| mwd::fuzzed::ism330dhcx(bytes));

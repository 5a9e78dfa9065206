#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    armbridge_fuzz::transparent_port::check(input);
});

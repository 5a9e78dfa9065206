#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    armbridge_fuzz::protocol2::check(input);
});

#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    grasp_fuzz::grasps(data);
});

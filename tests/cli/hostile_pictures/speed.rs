//! How fast a processor is just now: machines differ, and other tests run beside.

use std::fs;
use std::io;

use flate2::read::ZlibDecoder;

/// How often [`super::png::bomb`] is unpacked, so that a hundredth of a second is little of it.
const TIMES: usize = 8;
/// What that took where the limits were set, in milliseconds.
const UNPACKING: u64 = 480;

/// How many times slower than there the processor is, at least a half.
pub(super) fn slower() -> f64 {
    let now = || milliseconds("/proc/thread-self/stat");
    let bomb = super::png::bomb();
    let before = now();
    for _ in 0..TIMES {
        io::copy(&mut ZlibDecoder::new(bomb), &mut io::sink()).expect("a sound stream");
    }
    let taken = now() - before;
    if std::env::var_os("SHOW_COSTS").is_some() {
        println!("unpacking {TIMES} bombs took {taken} ms");
    }
    (taken as f64 / UNPACKING as f64).max(0.5)
}

/// The processor time that a file of the form of `/proc/PID/stat` says.
pub(super) fn milliseconds(stat: &str) -> u64 {
    let stat = fs::read_to_string(stat).expect("the process runs");
    // The name in parentheses may hold spaces; user and system time are the 14th and 15th field, in
    // hundredths of a second.
    let after_name = stat.rsplit(')').next().expect("fields");
    let ticks = after_name.split_whitespace().skip(11).take(2);
    10 * ticks.map(|ticks| ticks.parse::<u64>().expect("a number")).sum::<u64>()
}

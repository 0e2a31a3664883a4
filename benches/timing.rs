//! How the benches time, and the one line that each figure is written as.

use cpu_time::ThreadTime;

/// Processor time of the calling thread over several runs (ms): what others on the machine take does not count.
#[derive(Clone, Copy, Debug)]
pub struct Timed {
    pub least: f64,
    pub median: f64,
}

/// Times `runs` runs of `f`, after one that warms up.
pub fn time(runs: usize, mut f: impl FnMut()) -> Timed {
    f();
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let start = ThreadTime::now();
            f();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    Timed { least: times[0], median: times[runs / 2] }
}

/// Prints a figure as `benches/run` reads it: what was done, by whom, least and median time (ms), error or remark.
pub fn line(what: &str, who: &str, timed: Timed, remark: &str) {
    println!("{what}\t{who}\t{:.6}\t{:.6}\t{remark}", timed.least, timed.median);
}

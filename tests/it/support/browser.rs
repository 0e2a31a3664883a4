//! A headless browser, where there is one.

use std::path::Path;
use std::process::Command;

/// Names under which browsers are found.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// A browser, or `None` with a word on why its tests are left out.
pub fn browser() -> Option<&'static str> {
    let there = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    let found = BROWSERS.into_iter().find(there);
    if found.is_none() {
        eprintln!("SKIPPED: no Chromium here, so no page was opened in a browser (Debian: apt-get install chromium)");
    }
    found
}

/// A call of the browser in a window of this size, without a network; its profile is kept in `folder`.
pub fn call(browser: &str, folder: &Path, (width, height): (u32, u32), dark: bool) -> Command {
    let mut command = Command::new(browser);
    command
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .arg("--disable-features=IsolateOrigins,site-per-process")
        .args(["--host-resolver-rules=MAP * ~NOTFOUND", "--enable-logging=stderr", "--virtual-time-budget=20000"])
        .arg(format!("--blink-settings=preferredColorScheme={}", i32::from(!dark)))
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("--window-size={width},{height}"));
    command
}

//! A headless browser.

use std::path::Path;
use std::process::Command;

/// Names under which browsers are found.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// A browser; the tests that need one are ignored by name, so that a machine without one passes nothing.
pub fn browser() -> &'static str {
    let there = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success());
    BROWSERS.into_iter().find(there).expect("no Chromium here (Debian: apt-get install chromium)")
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

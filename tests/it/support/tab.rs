//! A tab of a headless browser that a test drives: the DevTools protocol over two pipes, a message and a zero byte at a time.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::browser::browser;
use super::command::Ending;

/// A tab, with all that it complained about.
pub struct Tab {
    _child: Ending,
    to: File,
    from: BufReader<File>,
    session: Value,
    asked: u64,
    /// Errors of the console, exceptions, and addresses beyond the desk's own.
    pub complaints: Vec<String>,
    own: String,
    _folder: tempfile::TempDir,
}

impl Tab {
    /// Opens an address in a window of this size.
    pub fn open(address: &str, (width, height): (u32, u32)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let pipes = ["in", "out"].map(|name| folder.path().join(name));
        assert!(Command::new("mkfifo").args(&pipes).status().unwrap().success());
        // Chromium reads what it is asked from file 3 and answers on file 4.
        let script = "exec \"$0\" --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking \
             --disable-component-update --disable-sync --remote-debugging-pipe \"$@\" 3<\"$PIPES/in\" 4>\"$PIPES/out\"";
        let mut command = Command::new("sh");
        command.args(["-c", script, browser()]).env("PIPES", folder.path());
        command.arg(format!("--user-data-dir={}", folder.path().join("profile").display()));
        command.arg(format!("--window-size={width},{height}"));
        let child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let to = fs::OpenOptions::new().write(true).open(&pipes[0]).unwrap();
        let from = BufReader::new(File::open(&pipes[1]).unwrap());
        let own = address.split('/').take(3).collect::<Vec<_>>().join("/");
        let (session, complaints) = (Value::Null, Vec::new());
        let mut tab = Self { _child: Ending(child), to, from, session, asked: 0, complaints, own, _folder: folder };
        let target = tab.call("Target.createTarget", json!({"url": "about:blank"}))["targetId"].clone();
        tab.session =
            tab.call("Target.attachToTarget", json!({"targetId": target, "flatten": true}))["sessionId"].clone();
        for domain in ["Runtime.enable", "Network.enable", "Log.enable", "Page.enable"] {
            tab.call(domain, json!({}));
        }
        let size = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 700});
        tab.call("Emulation.setDeviceMetricsOverride", size);
        tab.call("Page.navigate", json!({"url": address}));
        tab
    }

    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.asked += 1;
        let mut message = json!({"id": self.asked, "method": method, "params": parameters});
        if !self.session.is_null() {
            message["sessionId"] = self.session.clone();
        }
        self.to.write_all(format!("{message}\0").as_bytes()).unwrap();
        loop {
            let mut bytes = Vec::new();
            self.from.read_until(0, &mut bytes).unwrap();
            bytes.pop();
            let told: Value = serde_json::from_slice(&bytes).expect("the browser has ended");
            if told["id"] == self.asked {
                assert!(told["error"].is_null(), "{method}: {}", told["error"]);
                return told["result"].clone();
            }
            self.hear(&told);
        }
    }

    fn hear(&mut self, told: &Value) {
        let of = &told["params"];
        match told["method"].as_str() {
            Some("Runtime.exceptionThrown") => self.complaints.push(of["exceptionDetails"].to_string()),
            Some("Log.entryAdded") if of["entry"]["level"] == "error" => self.complaints.push(of["entry"].to_string()),
            Some("Runtime.consoleAPICalled") if of["type"] == "error" => self.complaints.push(of["args"].to_string()),
            Some("Network.requestWillBeSent") => {
                let address = of["request"]["url"].as_str().unwrap_or_default();
                if !address.starts_with(&self.own) && !address.starts_with("data:") {
                    self.complaints.push(format!("asked for {address}"));
                }
            }
            _ => {}
        }
    }

    /// What a script of the page gives; promises are waited for.
    pub fn script(&mut self, script: &str) -> Value {
        let asked = json!({"expression": script, "awaitPromise": true, "returnByValue": true});
        let gave = self.call("Runtime.evaluate", asked);
        assert!(gave["exceptionDetails"].is_null(), "{script}: {}", gave["exceptionDetails"]);
        gave["result"]["value"].clone()
    }

    /// Waits until a script gives something that is true, and returns it.
    pub fn wait(&mut self, script: &str, at_most: Duration) -> Value {
        let begin = Instant::now();
        loop {
            let gave = self.script(script);
            if !matches!(gave, Value::Null | Value::Bool(false)) {
                return gave;
            }
            assert!(begin.elapsed() < at_most, "never: {script}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Clicks what this selector finds.
    pub fn click(&mut self, selector: &str) {
        let quoted = json!(selector);
        self.script(&format!("document.querySelector({quoted}).dispatchEvent(new MouseEvent('click', {{bubbles: true, cancelable: true}}))"));
    }

    /// The window as a picture.
    pub fn picture(&mut self, path: &Path) {
        let shot = self.call("Page.captureScreenshot", json!({"format": "png"}));
        fs::write(path, decoded(shot["data"].as_str().unwrap())).unwrap();
    }
}

/// The bytes of a text in base64.
fn decoded(text: &str) -> Vec<u8> {
    let value = |byte: u8| match byte {
        b'A'..=b'Z' => Some(u32::from(byte - b'A')),
        b'a'..=b'z' => Some(u32::from(byte - b'a') + 26),
        b'0'..=b'9' => Some(u32::from(byte - b'0') + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let (mut bytes, mut held, mut bits) = (Vec::new(), 0_u32, 0);
    for six in text.bytes().filter_map(value) {
        held = (held << 6 | six) & 0xffff;
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push((held >> bits & 0xff) as u8);
        }
    }
    bytes
}

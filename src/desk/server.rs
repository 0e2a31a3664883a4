//! One page and its messages on the loopback.

use std::io::{Cursor, Read};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tiny_http::{Header, Method, Request, Response};

use super::guard::{Guard, Refusal};
use super::message::BothGauges;
use super::running::Task;
use super::shared::Shared;
use super::state::{Change, Desk};
use super::task;
use super::trace::{SensorCurves, Window};
use crate::complaint::{Complaint, Kind};
use crate::context::{Context, Interrupted};

/// How often the server looks whether it is to end.
const LOOK: Duration = Duration::from_millis(40);
/// How long a tab waits for news before it asks again.
const WAIT: Duration = Duration::from_secs(10);
/// How long the desk stays after its last tab was closed.
const LINGER: Duration = Duration::from_secs(60);
/// Most requests that are answered at a time, and most bytes of one.
const MOST_AT_ONCE: usize = 64;
const MOST_BYTES: u64 = 64 * 1024;

const PAGE: &str = include_str!("page.html");
const SCRIPT: &str = include_str!("page.js");
const STYLE: &str = concat!(include_str!("../report/html/page.css"), include_str!("page.css"));
/// What every answer says: nothing from elsewhere, nothing kept, nothing given to others.
const HEADERS: [(&str, &str); 7] = [
    (
        "Content-Security-Policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; base-uri 'none'; \
         form-action 'none'; frame-ancestors 'none'",
    ),
    ("X-Content-Type-Options", "nosniff"),
    ("X-Frame-Options", "DENY"),
    ("Referrer-Policy", "no-referrer"),
    ("Cross-Origin-Opener-Policy", "same-origin"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Cache-Control", "no-store"),
];

/// A desk at its address.
pub struct Server {
    http: tiny_http::Server,
    guard: Arc<Guard>,
    shared: Arc<Shared>,
}

/// What the page asks for.
#[derive(Debug, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case", deny_unknown_fields)]
enum Asked {
    Curves { window: Window, check: bool },
    Change { changes: Vec<Change>, window: Window, check: bool },
    Add { effect: String },
    AddFound { number: usize },
    Undo,
    Begin { task: Task },
    Stop,
    Text,
    Save { name: String, replace: bool },
}

/// The curves of a record where the sliders stand.
#[derive(Serialize)]
struct Drawn {
    revision: u64,
    gauges: BothGauges,
    sensors: Vec<SensorCurves>,
}

#[derive(Serialize)]
struct Said<'a> {
    said: &'a str,
}

struct Answer {
    status: u16,
    kind: &'static str,
    body: Vec<u8>,
}

impl Server {
    /// Takes a port of the loopback, any that is free without one.
    ///
    /// # Errors
    /// A port that is taken, or a system without random numbers.
    pub fn new(desk: Desk, port: Option<u16>) -> Result<Self, Complaint> {
        let failed = |error: String| {
            let port = port.map_or_else(|| "a port".to_owned(), |port| format!("port {port}"));
            Complaint::new(Kind::Locked, format!("{port} of this machine cannot be had: {error}"))
                .help("give another one with `--port`, or leave it away")
        };
        let http =
            tiny_http::Server::http(("127.0.0.1", port.unwrap_or(0))).map_err(|error| failed(error.to_string()))?;
        let taken = http.server_addr().to_ip().map(|address| address.port());
        let guard = Guard::new(taken.ok_or_else(|| failed("it has no number".to_owned()))?)?;
        Ok(Self { http, guard: Arc::new(guard), shared: Arc::new(Shared::new(desk)) })
    }

    /// Where the page is, with the secret.
    pub fn address(&self) -> String {
        self.guard.address()
    }

    /// Serves the page until its last tab was closed.
    ///
    /// # Errors
    /// The context was cancelled.
    pub fn serve(&self, context: &Context) -> Result<(), Interrupted> {
        loop {
            context.check()?;
            if let Ok(Some(request)) = self.http.recv_timeout(LOOK) {
                self.answer(request);
            }
            if self.shared.is_left_for(LINGER) {
                return Ok(());
            }
        }
    }

    /// Answers in a thread of its own: some wait for news.
    fn answer(&self, mut request: Request) {
        let (guard, shared) = (Arc::clone(&self.guard), Arc::clone(&self.shared));
        if shared.busy.fetch_add(1, Ordering::SeqCst) >= MOST_AT_ONCE {
            shared.busy.fetch_sub(1, Ordering::SeqCst);
            send(request, Answer::plain(503, "too many requests at a time"));
            return;
        }
        std::thread::spawn(move || {
            let answer = match guard.admits(&request) {
                Ok(path) => answered(&shared, &path, &mut request),
                Err(refusal) => Answer::refused(refusal),
            };
            send(request, answer);
            shared.busy.fetch_sub(1, Ordering::SeqCst);
        });
    }
}

fn send(request: Request, Answer { status, kind, body }: Answer) {
    let length = body.len();
    let pairs = HEADERS.into_iter().chain([("Content-Type", kind)]);
    let headers = pairs.filter_map(|(name, value)| Header::from_bytes(name, value).ok()).collect();
    // Whoever has gone away needs no answer.
    let _ = request.respond(
        Response::new(status.into(), headers, Cursor::new(body), Some(length), None).with_chunked_threshold(usize::MAX),
    );
}

impl Answer {
    fn plain(status: u16, text: &str) -> Self {
        Self { status, kind: "text/plain; charset=utf-8", body: text.as_bytes().to_vec() }
    }

    fn refused(refusal: Refusal) -> Self {
        Self::plain(
            refusal as u16,
            match refusal {
                Refusal::NotFound => "there is nothing here",
                Refusal::Forbidden => "not from here",
                Refusal::NotJson => "JSON, please",
            },
        )
    }

    fn json(status: u16, value: &impl Serialize) -> Self {
        match serde_json::to_vec(value) {
            Ok(body) => Self { status, kind: "application/json", body },
            Err(error) => Self::plain(500, &error.to_string()),
        }
    }

    fn complaint(complaint: &Complaint) -> Self {
        Self::json(422, &Said { said: &complaint.to_string() })
    }
}

fn answered(shared: &Arc<Shared>, path: &str, request: &mut Request) -> Answer {
    let (path, query) = path.split_once('?').unwrap_or((path, ""));
    let own = |kind, text: &str| Answer { status: 200, kind, body: text.as_bytes().to_vec() };
    match (request.method(), path) {
        (Method::Get, "") => own("text/html; charset=utf-8", PAGE),
        (Method::Get, "page.js") => own("text/javascript; charset=utf-8", SCRIPT),
        (Method::Get, "page.css") => own("text/css; charset=utf-8", STYLE),
        (Method::Get, "state") => news(shared, query.strip_prefix("since=").and_then(|since| since.parse().ok())),
        (Method::Post, "ask") => {
            let mut body = String::new();
            let read = request.as_reader().take(MOST_BYTES + 1).read_to_string(&mut body);
            if read.is_err() || body.len() as u64 > MOST_BYTES {
                return Answer::plain(413, "too much, or no text");
            }
            match serde_json::from_str(&body) {
                Ok(asked) => done(shared, asked).unwrap_or_else(|complaint| Answer::complaint(&complaint)),
                Err(error) => Answer::plain(400, &error.to_string()),
            }
        }
        _ => Answer::refused(Refusal::NotFound),
    }
}

/// The state, as soon as it is another one than that which the tab has.
fn news(shared: &Shared, since: Option<u64>) -> Answer {
    shared.hear();
    let mut desk = shared.desk_after(since, WAIT);
    match desk.catch_up().and_then(|()| desk.message()) {
        Ok(state) => Answer::json(200, &state),
        Err(complaint) => Answer::complaint(&complaint),
    }
}

fn done(shared: &Arc<Shared>, asked: Asked) -> Result<Answer, Complaint> {
    shared.hear();
    let changed = |work: &dyn Fn(&mut Desk) -> Result<(), Complaint>| {
        let mut desk = shared.desk();
        desk.idle()?;
        work(&mut desk)?;
        drop(desk);
        shared.tell();
        Ok(Answer::json(200, &Said { said: "done" }))
    };
    match asked {
        Asked::Curves { window, check } => {
            let mut desk = shared.desk();
            desk.catch_up()?;
            drawn(&desk, window, check)
        }
        Asked::Change { changes, window, check } => {
            let mut desk = shared.desk();
            desk.change(&changes, check)?;
            let answer = drawn(&desk, window, check);
            drop(desk);
            shared.tell();
            answer
        }
        Asked::Add { effect } => changed(&|desk| desk.add_by_hand(&effect)),
        Asked::AddFound { number } => changed(&|desk| desk.add_found(number)),
        Asked::Undo => changed(&Desk::undo),
        Asked::Begin { task } => {
            task::begin(shared, task)?;
            Ok(Answer::json(200, &Said { said: "begun" }))
        }
        Asked::Stop => {
            if let Some(running) = &shared.desk().running {
                running.context.cancel();
            }
            Ok(Answer::json(200, &Said { said: "stopping" }))
        }
        Asked::Text => Ok(Answer::json(200, &Said { said: &shared.desk().current_text()? })),
        Asked::Save { name, replace } => changed(&|desk| desk.save(&name, replace).map(drop)),
    }
}

fn drawn(desk: &Desk, window: Window, check: bool) -> Result<Answer, Complaint> {
    let trace = if check { desk.check.as_ref().unwrap_or(&desk.fit) } else { &desk.fit };
    let drawn = Drawn { revision: desk.revision, gauges: desk.gauges()?, sensors: trace.curves(&desk.rig, window)? };
    Ok(Answer::json(200, &drawn))
}

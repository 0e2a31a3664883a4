//! Who may ask: this machine, under the name of this machine, with the secret of this run, from no other page.

use std::fmt::Write;

use tiny_http::{Header, Method, Request};

use crate::complaint::{Complaint, Kind};

/// Bytes of a secret: more than anybody can guess.
const SECRET_BYTES: usize = 24;

/// Why a request is not answered, as a status of HTTP.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// Not the address of this run.
    NotFound = 404,
    /// Under another name, as after DNS rebinding, or from another page.
    Forbidden = 403,
    /// No JSON, as forms of other pages send.
    NotJson = 415,
}

/// What a request has to know.
#[derive(Debug)]
pub struct Guard {
    secret: String,
    hosts: [String; 2],
}

impl Guard {
    /// With a new secret, for a server at this port.
    ///
    /// # Errors
    /// The system gives no random numbers.
    pub fn new(port: u16) -> Result<Self, Complaint> {
        let mut bytes = [0_u8; SECRET_BYTES];
        getrandom::fill(&mut bytes).map_err(|error| {
            Complaint::new(
                Kind::Unreadable,
                format!("the system gives no random numbers for a secret address: {error}"),
            )
        })?;
        let mut secret = String::with_capacity(2 * SECRET_BYTES);
        for byte in bytes {
            // Writing to a String cannot fail.
            let _ = write!(secret, "{byte:02x}");
        }
        Ok(Self { secret, hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")] })
    }

    /// Where the page is.
    pub fn address(&self) -> String {
        format!("http://{}/{}/", self.hosts[0], self.secret)
    }

    /// What of its address a request asks for, behind the secret.
    ///
    /// # Errors
    /// Why it is not answered.
    pub fn admits(&self, request: &Request) -> Result<String, Refusal> {
        let all = |name: &'static str| -> Vec<&str> {
            let named = |header: &&Header| header.field.equiv(name);
            request.headers().iter().filter(named).map(|header| header.value.as_str()).collect()
        };
        let [host] = all("Host")[..] else { return Err(Refusal::Forbidden) };
        let is_ours = |origin: &&str| self.hosts.iter().any(|own| origin.strip_prefix("http://") == Some(own));
        if self.hosts.iter().all(|own| own != host) || !all("Origin").iter().all(is_ours) {
            return Err(Refusal::Forbidden);
        }
        let given = request.url().strip_prefix('/').and_then(|path| path.split_once('/'));
        let Some((secret, rest)) = given else { return Err(Refusal::NotFound) };
        if !is_same(secret.as_bytes(), self.secret.as_bytes()) {
            return Err(Refusal::NotFound);
        }
        if *request.method() == Method::Post {
            // Every browser says from where a page posts.
            if all("Origin").len() != 1 {
                return Err(Refusal::Forbidden);
            }
            if all("Content-Type") != ["application/json"] {
                return Err(Refusal::NotJson);
            }
        }
        Ok(rest.to_owned())
    }
}

/// Whether two texts are the same, found in a time that does not tell where they differ.
fn is_same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
}

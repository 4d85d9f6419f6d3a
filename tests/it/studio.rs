//! The studio answers whoever has its token and nobody else, shows what the other commands make, and leaves nothing
//! half-written.

use super::support::builds::{SMALL, command, edited, files, folder, morion, parsed, save, told};
use morion::internals::design::design;
use morion::internals::num::{asin, atan2, degrees};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

/// A running studio; it ends when it is dropped.
struct Studio {
    child: Child,
    port: u16,
    token: String,
}

impl Drop for Studio {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Status, fields and body of an answer.
struct Answer {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Answer {
    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap_or_else(|_| panic!("{}", self.text()))
    }

    fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }
}

impl Studio {
    /// The studio on `small.toml` with this text, in `folder`.
    fn open(folder: &Path, text: &str) -> Self {
        save(folder, text);
        let arguments =
            ["studio", "small.toml", "--port", "0", "--no-open", "--format", "json", "--quiet"];
        let mut child =
            command(folder).args(arguments).stdout(Stdio::piped()).spawn().expect("it starts");
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address: Value = serde_json::from_str(&line).unwrap();
        let address = address["address"].as_str().unwrap();
        let rest = address.strip_prefix("http://127.0.0.1:").unwrap();
        let (port, token) = rest.split_once("/?token=").unwrap();
        Self { child, port: port.parse().unwrap(), token: token.to_owned() }
    }

    /// Sends `head` and `body` as they are.
    fn send(&self, head: &str, body: &[u8]) -> Answer {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.write_all(head.as_bytes()).unwrap();
        // (What is refused may not be read to its end.)
        let _ = stream.write_all(body);
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").expect("an answer");
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        let body = bytes[end + 4..].to_vec();
        let body = if head.contains("chunked") { unchunked(&body) } else { body };
        Answer { status, head, body }
    }

    /// A request with further header lines in the place of the usual ones that they name.
    fn ask(&self, verb: &str, path: &str, body: &[u8], fields: &[(&str, &str)]) -> Answer {
        let host = format!("127.0.0.1:{}", self.port);
        let usual = [("Host", &*host), ("X-Morion-Token", &*self.token)];
        let is_usual = |field: &&(&str, &str)| fields.iter().all(|(name, _)| name != &field.0);
        let lines: String = usual
            .iter()
            .filter(is_usual)
            .chain(fields)
            .map(|(name, value)| format!("{name}: {value}\r\n"))
            .collect();
        let length = body.len();
        let head = format!(
            "{verb} {path} HTTP/1.1\r\n{lines}Connection: close\r\nContent-Length: {length}\r\n\r\n"
        );
        self.send(&head, body)
    }

    fn post(&self, path: &str, body: &Value) -> Answer {
        self.ask("POST", path, body.to_string().as_bytes(), &[])
    }

    fn get(&self, path: &str) -> Answer {
        self.ask("GET", path, b"", &[])
    }

    /// The status of the build once `is_there` holds of it.
    fn build_until(&self, is_there: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            let status = self.get("/build").json();
            if is_there(&status) {
                return status;
            }
            assert!(began.elapsed() < Duration::from_secs(300), "{status}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// The bytes of a body in chunks.
fn unchunked(mut body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    while let Some(end) = body.windows(2).position(|two| two == b"\r\n") {
        let length = usize::from_str_radix(std::str::from_utf8(&body[..end]).unwrap(), 16).unwrap();
        bytes.extend_from_slice(&body[end + 2..end + 2 + length]);
        body = &body[(end + 4 + length).min(body.len())..];
    }
    bytes
}

fn small(text: &str) -> Value {
    json!({ "name": "small", "text": text })
}

#[test]
fn who_has_no_token_or_comes_from_elsewhere_is_refused() {
    let folder = folder();
    let studio = Studio::open(folder.path(), SMALL);
    let page =
        studio.ask("GET", &format!("/?token={}", studio.token), b"", &[("X-Morion-Token", "")]);
    assert_eq!(page.status, 403, "an empty header is a wrong one");
    let host = format!("127.0.0.1:{}", studio.port);
    let page = format!(
        "GET /?token={} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n",
        studio.token
    );
    let page = studio.send(&page, b"");
    assert_eq!(page.status, 200);
    for rule in ["default-src 'none'", "connect-src 'self'", "frame-ancestors 'none'"] {
        assert!(page.head.contains(rule), "{}", page.head);
    }
    let wrong = "0".repeat(64);
    let elsewhere = format!("evil.example:{}", studio.port);
    let good = [("Origin", &*format!("http://localhost:{}", studio.port))];
    assert_eq!(studio.ask("GET", "/build", b"", &good).status, 200);
    for fields in [
        [("X-Morion-Token", &*wrong)],
        [("X-Morion-Token", &studio.token[..63])],
        [("Host", &*elsewhere)],
        [("Host", "127.0.0.1")],
        [("Origin", "http://evil.example")],
        [("Origin", "null")],
    ] {
        for path in ["/", "/build", "/nothing"] {
            let answer = studio.ask("GET", path, b"", &fields);
            assert_eq!(answer.status, 403, "{fields:?} {path}");
            assert!(answer.json()["error"]["message"].is_string());
        }
    }
    // A token in the address is for links alone.
    let path = format!("/build?token={}", studio.token);
    let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    assert_eq!(studio.send(&request, b"").status, 403);
}

#[test]
fn nothing_outside_its_builds_is_reachable() {
    let folder = folder();
    let studio = Studio::open(folder.path(), SMALL);
    for path in [
        "/files/../../small.toml",
        "/files/..%2f..%2fsmall.toml",
        "/../small.toml",
        "/files//etc/passwd",
        "/files/",
        "/small.toml",
    ] {
        assert_eq!(studio.get(path).status, 404, "{path}");
    }
    for name in ["../small", "a/b", "", "a.b", "C:\\x"] {
        let answer = studio.post("/build", &json!({ "name": name, "text": SMALL }));
        assert_eq!(answer.status, 422, "{name}");
    }
    let names_a_file =
        SMALL.replace("[accept]", "[tolerance]\nmap_file = \"small.toml\"\n[accept]");
    for (path, status) in [("/follow", 200), ("/build", 422), ("/picture", 422)] {
        let answer = studio.post(path, &small(&names_a_file));
        assert_eq!(answer.status, status);
        let said = answer.json()["error"]["message"].to_string();
        assert!(said.contains("tolerance.map_file"), "{said}");
    }
    let long = vec![b' '; 1_000_001];
    assert_eq!(studio.ask("POST", "/follow", &long, &[]).status, 413);
    assert_eq!(studio.ask("POST", "/follow", b"{", &[]).status, 400);
    assert!(!folder.path().join("out").exists(), "nothing was written");
}

/// The sketch that follows a slider is the mirror of a low degree by least squares, seen more coarsely; of one that is made so itself it is
/// that mirror.
#[test]
fn a_sketch_is_the_mirror_by_least_squares() {
    let folder = folder();
    let studio = Studio::open(folder.path(), SMALL);
    let of_degree = |words: &str| edited(SMALL, &[("degree = 8", words)]);
    let seen = |text: &str, sketch: bool| {
        let asked = json!({ "name": "small", "text": text, "sketch": sketch });
        studio.post("/follow", &asked).json()["seen"].take()
    };
    let fine = of_degree("degree = 14\nminimax = true");
    let sketch = seen(&fine, true);
    assert!(sketch["picture"].is_string() && sketch == seen(&of_degree("degree = 10"), true));
    // The errors are not those of every second pixel.
    let errors = |seen: &Value| {
        let facts = seen["judged"]["facts"].as_array().unwrap();
        facts.iter().find(|fact| fact[0] == "picture").unwrap()[1].clone()
    };
    assert_ne!(errors(&sketch), errors(&seen(&fine, false)));
    let coarse = of_degree("degree = 6");
    assert_eq!(errors(&seen(&coarse, true)), errors(&seen(&coarse, false)));
}

#[test]
fn the_picture_is_that_of_render_byte_for_byte() {
    let folder = folder();
    let studio = Studio::open(folder.path(), SMALL);
    let picture = studio.post("/picture", &small(SMALL));
    assert_eq!(picture.status, 200, "{}", picture.text());
    let arguments = ["render", "small.toml", "--scene", "grid", "--out", "rendered"];
    let rendered = morion(folder.path(), &arguments);
    assert_eq!(told(&rendered).0, 0);
    let wanted = &files(&folder.path().join("rendered/small"))["render-grid.png"];
    assert!(picture.body == *wanted, "{} {}", picture.body.len(), wanted.len());
}

/// The panels of a valley are in each other's way: pixels that a frame's trace finds shadowed are lost here too.
#[test]
fn pixels_that_see_the_part_itself_are_lost() {
    let folder = folder();
    let valley = edited(SMALL, &[("\"crest\"", "\"valley\"")]);
    let studio = Studio::open(folder.path(), &valley);
    assert!(told(&morion(folder.path(), &["frame", "small.toml", "--out", "traced"])).0 < 2);
    let made = files(&folder.path().join("traced/small"));
    let frame: Value = serde_json::from_slice(&made["frame.json"]).unwrap();
    let lost = &frame["frame"]["lost"];
    let of = |keys: &[&str]| keys.iter().map(|key| lost[*key].as_f64().unwrap()).sum::<f64>();
    let (shadow, unseen) = (of(&["shadow"]), of(&["beyond", "missed"]));
    assert!(shadow > 100.0, "{lost}");
    for path in ["/follow", "/estimate"] {
        let mut answer = studio.post(path, &small(&valley)).json();
        let seen = if path == "/follow" { answer["seen"].take() } else { answer };
        let told = seen["judged"]["pixels_lost"].as_f64().unwrap();
        // Both meshes are coarse, and differ at the shadow's edge.
        assert!((told - unseen - shadow).abs() < 0.15 * shadow, "{path}: {told} and {lost}");
    }
}

#[test]
fn a_change_keeps_the_rest_of_the_text_and_faults_are_those_of_check() {
    let folder = folder();
    let studio = Studio::open(folder.path(), SMALL);
    let text = SMALL.replace("width_mm = 15", "width_mm = 15 # as wide\nmine = 3 # my own");
    let edits = json!([
        { "path": ["part", "width_mm"], "value": 16.5 },
        { "path": ["part", "base_mm"], "value": 6 },
    ]);
    let edit = json!({ "name": "small", "text": text, "edits": edits });
    let edited = studio.post("/follow", &edit).json();
    let wanted = text.replace("= 15 #", "= 16.5 #").replace("base_mm = 2", "base_mm = 6");
    assert_eq!(edited["text"], wanted);
    assert_eq!(edited["values"]["part.width_mm"]["value"], 16.5);
    let found = studio.post("/follow", &small(&text)).json();
    assert_eq!((&found["text"], &found["seen"]), (&json!(text), &Value::Null));
    save(folder.path(), &text);
    let checked = morion(folder.path(), &["check", "small.toml", "--format", "json"]);
    let lines: Vec<Value> = told(&checked)
        .1
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap()["error"].clone())
        .collect();
    assert_eq!(found["errors"], json!(lines));
    assert_eq!(found["values"]["part.width_mm"]["value"], 15);
    assert_eq!(found["values"]["part.mine"]["value"], 3);
    // A design that is refused says what helps.
    let near = "[camera.pinhole]\ndistance_mm = 2\nhfov_deg = 170";
    let steep =
        SMALL.replace("[camera.orthographic]", near).replace("width_mm = 15", "width_mm = 60");
    let refused = studio.post("/follow", &small(&steep));
    assert_eq!(refused.status, 200, "{}", refused.text());
    let arguments = ["render", "small.toml", "--scene", "grid", "--smooth", "--format", "json"];
    save(folder.path(), &steep);
    let told = told(&morion(folder.path(), &arguments)).1;
    let told: Value = serde_json::from_str(told.lines().next().unwrap()).unwrap();
    assert_eq!(refused.json()["error"], told["error"]);
}

#[test]
fn hostile_text_stays_text() {
    let folder = folder();
    let hostile = "</script><script>alert(1)</script>";
    let text = SMALL.replace("A small conquistador", hostile);
    let studio = Studio::open(folder.path(), &text);
    let host = format!("127.0.0.1:{}", studio.port);
    let request = format!(
        "GET /?token={} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n",
        studio.token
    );
    assert!(!studio.send(&request, b"").text().contains("alert(1)"), "the page holds no data");
    let start = studio.post("/start", &json!({}));
    assert!(start.head.to_lowercase().contains("content-type: application/json"));
    assert!(start.head.to_lowercase().contains("nosniff"));
    assert_eq!(start.json()["text"], text);
    for text in ["a = [[[[", "\u{0}", "\u{202e}", "a = '''", "[a.b.c.d.e.f.g.h.i.j.k.l]", ""] {
        let answer = studio.post("/follow", &small(text));
        assert_eq!(answer.status, 200, "{text:?}");
        let answer = answer.json();
        assert!(answer["seen"].is_null() && answer["error"]["message"].is_string(), "{text:?}");
        assert_eq!(answer["error"], answer["errors"][0], "{text:?}");
        let edits = json!([{ "path": ["part", "width_mm"], "value": 1 }]);
        let edit = json!({ "name": "small", "text": text, "edits": edits });
        assert!([200, 422].contains(&studio.post("/follow", &edit).status), "{text:?}");
    }
}

#[test]
fn a_pixel_sees_what_the_design_shows_it() {
    let folder = folder();
    let studio = Studio::open(folder.path(), SMALL);
    let design = design(&parsed(SMALL)).unwrap();
    let (camera, mirror) = (&design.camera, &design.mirror);
    for [x, y] in [[0, 0], [80, 20], [159, 119], [30, 90]] {
        let found =
            studio.post("/pixel", &json!({ "name": "small", "text": SMALL, "x": x, "y": y }));
        let found = found.json();
        let number = |value: &Value| value.as_f64().unwrap();
        // A telecentric ray keeps its X and Y, and is reflected by the law of reflection.
        let image = camera.image_point(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let hit: Vec<f64> = found["hit_mm"].as_array().unwrap().iter().map(number).collect();
        assert!((hit[0] - image.x).abs() < 1e-9 && (hit[1] - image.y).abs() < 1e-9, "{found}");
        let normal = mirror.normal(image, &mirror.at(image)).normalize();
        let away = 2.0 * normal.z * normal - morion::internals::geom::DVec3::Z;
        let angles = [atan2(away.x, away.y), asin(away.z)].map(degrees);
        assert!((number(&found["azimuth_deg"]) - angles[0]).abs() < 1e-9, "{found} {angles:?}");
        assert!((number(&found["elevation_deg"]) - angles[1]).abs() < 1e-9, "{found} {angles:?}");
        let most = design.facts.pixel_error_px.unwrap().max;
        assert!(number(&found["error_px"]) <= most + 1e-9, "{found}");
    }
    let outside = json!({ "name": "small", "text": SMALL, "x": 160, "y": 0 });
    assert_eq!(studio.post("/pixel", &outside).status, 422);
}

#[test]
fn a_build_is_that_of_the_program_and_leaves_nothing_when_cancelled() {
    let folder = folder();
    let studio = Studio::open(folder.path(), SMALL);
    // One of many facets, which is cancelled.
    let long = SMALL.replace("chord_um = 20", "chord_um = 0.02");
    assert_eq!(studio.post("/build", &small(&long)).status, 200);
    assert_eq!(studio.post("/build", &small(&long)).status, 409, "one at a time");
    studio.build_until(|status| !status["lines"].as_array().unwrap().is_empty());
    assert_eq!(studio.post("/cancel", &json!({})).json()["state"], "cancelled");
    let made = folder.path().join("out/studio");
    assert_eq!(files_below(&made), ["small.toml"]);

    assert_eq!(studio.post("/build", &small(SMALL)).status, 200);
    let done = studio.build_until(|status| status["state"] != "running");
    assert_eq!((&done["state"], &done["verdict"]), (&json!("done"), &json!("pass")), "{done}");
    let names = done["files"].as_array().unwrap();
    for name in ["report.html", "report.json", "mirror.stl", "mirror.obj"] {
        assert!(names.contains(&json!(name)), "{done}");
        let answer = studio.get(&format!("/files/{name}"));
        let wanted = std::fs::read(made.join("small").join(name)).unwrap();
        assert!(answer.status == 200 && answer.body == wanted, "{name}: {}", answer.head);
    }
    let report = studio.get("/files/report.html").head;
    assert!(report.contains("sandbox allow-scripts; default-src 'none'"), "{report}");
    assert_eq!(studio.get("/files/small.toml").status, 404);
}

/// The build's own process does not outlive the studio, and leaves nothing of what it was writing.
#[cfg(unix)]
#[test]
fn a_studio_that_is_told_to_end_ends_its_build() {
    let long = SMALL.replace("chord_um = 20", "chord_um = 0.02");
    for signal in ["TERM", "INT"] {
        let folder = folder();
        let mut studio = Studio::open(folder.path(), SMALL);
        assert_eq!(studio.post("/build", &small(&long)).status, 200);
        studio.build_until(|status| !status["lines"].as_array().unwrap().is_empty());
        let id = studio.child.id().to_string();
        let children = format!("/proc/{id}/task");
        let child = std::fs::read_dir(children)
            .unwrap()
            .map(|task| std::fs::read_to_string(task.unwrap().path().join("children")).unwrap())
            .find(|children| !children.trim().is_empty())
            .expect("a build under way");
        let child = Path::new("/proc").join(child.split_whitespace().next().unwrap());
        assert!(child.exists());
        let sent = std::process::Command::new("kill").args(["-s", signal, &id]).status().unwrap();
        assert!(sent.success());
        let ended = (0..600).find_map(|_| {
            std::thread::sleep(std::time::Duration::from_millis(50));
            studio.child.try_wait().unwrap()
        });
        // (A shell starts what it puts into the background with SIGINT ignored, and the studio keeps to that.)
        let code = ended.expect("the studio goes on: is the signal ignored?").code();
        assert_eq!(code, Some(if signal == "TERM" { 143 } else { 130 }));
        assert!(!child.exists(), "the build goes on");
        assert_eq!(files_below(&folder.path().join("out/studio")), ["small.toml"], "{signal}");
    }
}

/// Names of all files below a folder.
fn files_below(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => names.extend(files_below(&path)),
            false => names.push(path.file_name().unwrap().to_string_lossy().into_owned()),
        }
    }
    names.sort();
    names
}

#[test]
fn what_cannot_be_opened_is_one_clear_error() {
    let folder = folder();
    let text = SMALL.replace("[accept]", "[tolerance]\nmap_file = \"a.csv\"\n[accept]");
    save(folder.path(), &text);
    for (arguments, said) in [
        (&["studio", "small.toml", "--no-open"][..], "tolerance.map_file"),
        (&["studio", "nothing", "--no-open"], "no such file"),
        (&["studio", "--port", "70000", "--no-open"], "70000"),
    ] {
        let (code, _, stderr) = told(&morion(folder.path(), arguments));
        assert_eq!(code, 2, "{arguments:?}");
        assert!(stderr.contains(said), "{stderr}");
    }
}

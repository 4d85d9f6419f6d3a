//! Profile text: what is read stays the same under a comment, what is refused is placed.

use morion::internals::profile::Profile;

const FILE: &str = "fuzzed.toml";

pub fn holds(bytes: &[u8]) {
    let read = Profile::parse("fuzzed", FILE, bytes);
    match read {
        Ok(profile) => {
            let more = [bytes, b"\n# a comment"].concat();
            // Only a profile as long as one may be gets too long by it.
            if let Ok(mut again) = Profile::parse("fuzzed", FILE, &more) {
                assert_ne!(again.sha256, profile.sha256);
                again.sha256.clone_from(&profile.sha256);
                assert_eq!(again, profile);
            } else {
                assert!(more.len() > 60_000, "a comment spoils the profile");
            }
        }
        Err(complaints) => {
            assert!(!complaints.0.is_empty(), "refused without a reason");
            // Bytes that are no text are placed after the text before them.
            let text = String::from_utf8_lossy(bytes);
            let lines: Vec<&str> = text.split('\n').collect();
            let mut before = (0, 0);
            for complaint in &complaints.0 {
                let place = (complaint.line, complaint.column);
                assert!(place >= before, "{complaint} comes after {before:?}");
                before = place;
                let line = complaint.line.checked_sub(1).and_then(|k| lines.get(k));
                let line = line.unwrap_or_else(|| panic!("{complaint}: no such line"));
                let columns = 1..=line.chars().count() + 1;
                assert!(columns.contains(&complaint.column), "{complaint}: no such column");
                assert!(!complaint.message.is_empty() && complaint.file == FILE);
                let shown = complaint.to_string();
                let hidden = |c: char| c.is_control() && c != '\n';
                assert!(!shown.contains(hidden), "{shown:?} would play tricks on a terminal");
                assert!(shown.len() < 4000, "{shown}");
            }
        }
    }
}

//! Pages: HTML that needs nothing beside it but pictures.

use super::answer::{Answer, AnswerRows};
use super::visible::visible;
use crate::results::Verdict;

/// Looks of every page.
const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:52rem;margin:2rem auto;\
padding:0 1rem;color:#222}table{border-collapse:collapse;width:100%;margin:1rem 0}\
th,td{text-align:left;vertical-align:top;padding:.3rem .6rem;border-bottom:1px solid #ddd}\
th{font-weight:600;white-space:nowrap;width:11rem}img{max-width:100%;image-rendering:pixelated}\
code{font-size:.85em;word-break:break-all}.pass{color:#15803d}.fail{color:#b91c1c}";

/// A page that is being written.
pub(super) struct Page {
    html: String,
}

impl Page {
    /// A page with a heading of the answer's profile and verdict; `style` is what it has beside the looks of
    /// all pages.
    pub(super) fn new(answer: &impl Answer, style: &str) -> Self {
        let head = answer.head();
        let name = head.profile.map_or(String::new(), |profile| escaped(&profile.name));
        let verdict = head.verdict.map_or("", Verdict::word);
        let html = format!(
            "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">\n<title>Morion: {name}</title>\n\
             <style>{STYLE}{style}</style>\n<h1>{name}: <span class=\"{verdict}\">{verdict}</span></h1>\n"
        );
        Self { html }
    }

    /// Adds a line of HTML.
    pub(super) fn raw(&mut self, line: &str) {
        self.html += line;
        self.html.push('\n');
    }

    /// Adds a paragraph.
    pub(super) fn paragraph(&mut self, text: &str) {
        self.raw(&format!("<p>{}</p>", escaped(text)));
    }

    /// Adds a list, unless it is empty.
    pub(super) fn list(&mut self, lines: &[String]) {
        let items: Vec<String> =
            lines.iter().map(|line| format!("<li>{}</li>\n", escaped(line))).collect();
        if !items.is_empty() {
            self.raw(&format!("<ul>\n{}</ul>", items.concat()));
        }
    }

    /// Adds a table of facts, and under them `more` rows of HTML.
    pub(super) fn facts(&mut self, rows: &AnswerRows, more: &str) {
        self.raw("<table>");
        for (heading, sentence) in rows.of_page() {
            let [heading, sentence] = [heading, sentence].map(escaped);
            self.raw(&format!("<tr><th>{heading}</th><td>{sentence}</td></tr>"));
        }
        self.raw(&format!("{more}</table>"));
    }

    /// Adds a table of numbers; `names` may hold entities.
    pub(super) fn numbers(&mut self, names: &[&str], rows: impl IntoIterator<Item = Vec<String>>) {
        let names: Vec<String> = names.iter().map(|name| format!("<th>{name}</th>")).collect();
        self.raw(&format!("<table class=\"n\">\n<thead><tr>{}</tr></thead>", names.concat()));
        for row in rows {
            let cells: Vec<String> =
                row.iter().map(|cell| format!("<td>{}</td>", escaped(cell))).collect();
            self.raw(&format!("<tr>{}</tr>", cells.concat()));
        }
        self.raw("</table>");
    }

    /// The whole page.
    pub(super) fn finish(mut self) -> String {
        self.raw("</html>");
        self.html
    }
}

/// `text` as it may stand in a page.
pub(super) fn escaped(text: &str) -> String {
    visible(text)
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    #[test]
    fn text_from_outside_cannot_become_markup() {
        assert_eq!(super::escaped("<b a=\"1\">&"), "&lt;b a=&quot;1&quot;&gt;&amp;");
    }
}

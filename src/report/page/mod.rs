//! Pages: HTML of one file that needs no network and nothing beside it.

mod drawing;
mod map_figure;
mod part_viewer;
mod sections;
mod side_view;

pub(super) use map_figure::map_figure;
#[cfg(feature = "studio")]
pub(crate) use map_figure::{MapLetter, map_letters};
pub(super) use part_viewer::part_figure;
#[cfg(feature = "studio")]
pub(crate) use part_viewer::{THREE, VIEWER};
pub(super) use sections::sections_figure;
pub(super) use side_view::side_view_figure;

use super::answer::{Answer, AnswerRows};
use super::meanings::meaning;
use super::visible::visible;
use crate::profile::Profile;
use crate::results::{FileFacts, Verdict, file_size};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;

/// Shades of every colour, for light and dark.
pub(super) const COLOURS: &str = include_str!("assets/colours.css");
/// Looks of drawings and plots.
pub(super) const DRAWING: &str = include_str!("assets/drawing.css");
/// Looks of every page: light and dark, on a telephone's width, and on A4.
pub(crate) const STYLE: &str = concat!(
    include_str!("assets/colours.css"),
    include_str!("assets/page.css"),
    include_str!("assets/drawing.css")
);

/// The page of a command on one profile; all lie in its folder, or in one below that.
struct CommandPage {
    file: &'static str,
    answers: &'static str,
    command: &'static str,
    /// Whether the command has an answer for a profile.
    suits: fn(&Profile) -> bool,
}

/// The pages of all commands.
const PAGES: [CommandPage; 6] = [
    CommandPage {
        file: "report.html",
        answers: "The part and its verdict",
        command: "build NAME",
        suits: |_| true,
    },
    CommandPage {
        file: "frame.html",
        answers: "Which pixels are filled, and how large they are in the world",
        command: "frame NAME",
        suits: |profile| profile.projection.is_some(),
    },
    CommandPage {
        file: "blur.html",
        answers: "How sharp each pixel is through the lens",
        command: "blur NAME --pupil-mm MM",
        suits: |_| true,
    },
    CommandPage {
        file: "tolerance.html",
        answers: "How many parts made with errors are good",
        command: "tolerance NAME",
        suits: |profile| profile.projection.is_some(),
    },
    CommandPage {
        file: "machining.html",
        answers: "What a ball cutter leaves",
        command: "machining NAME --ball-mm MM",
        suits: Profile::is_one_surface,
    },
    CommandPage {
        file: "program/program.html",
        answers: "Programs that mill the mirror, and what they leave",
        command: "program NAME",
        suits: |profile| profile.is_one_surface() && profile.part.forming.is_none(),
    },
];

/// A page that is being written.
pub(super) struct Page {
    html: String,
}

/// A picture or drawing with its title and what to conclude from it.
pub(super) struct Figure {
    /// Its title.
    pub title: String,
    /// HTML of what it shows.
    pub body: String,
    /// What to conclude.
    pub caption: String,
}

impl Page {
    /// A page with a heading of the answer's profile, what the page is about, the verdict and its reasons.
    pub(super) fn new(answer: &impl Answer, about: &str) -> Self {
        let head = answer.head();
        let name = head.profile.map_or(String::new(), |profile| escaped(&profile.name));
        let title = if about.is_empty() { name } else { format!("{name}: {about}") };
        let html = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title} - Morion</title>\n<style>\n{STYLE}</style></head>\n<body>\n<main>\n<h1>{title}</h1>\n"
        );
        let mut page = Self { html };
        if let Some(verdict) = head.verdict {
            page.verdict(verdict, "");
        }
        page
    }

    /// Adds the verdict, and a sentence behind it.
    pub(super) fn verdict(&mut self, verdict: Verdict, sentence: &str) {
        let (word, sentence) = (verdict.word(), escaped(sentence));
        self.raw(&format!(
            "<p class=\"verdict\">Verdict: <strong><span class=\"{word}\">{word}</span></strong>{sentence}</p>"
        ));
    }

    /// Adds a line of HTML.
    pub(super) fn raw(&mut self, line: &str) {
        self.html += line;
        self.html.push('\n');
    }

    /// Adds a heading.
    pub(super) fn heading(&mut self, text: &str) {
        self.raw(&format!("<h2>{}</h2>", escaped(text)));
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

    /// Adds lines as they are typed.
    pub(super) fn code(&mut self, lines: &[String]) {
        let lines: Vec<String> = lines.iter().map(|line| escaped(line)).collect();
        self.raw(&format!("<pre class=\"wide\" tabindex=\"0\">{}</pre>", lines.join("\n")));
    }

    /// Adds warnings, unless there are none.
    pub(super) fn warnings(&mut self, warnings: &[String]) {
        for warning in warnings {
            self.raw(&format!("<p><strong>Warning:</strong> {}</p>", escaped(warning)));
        }
    }

    /// Adds figures, side by side where there is room.
    pub(super) fn figures(&mut self, figures: impl IntoIterator<Item = Figure>) {
        self.raw("<div class=\"figures\">");
        for Figure { title, body, caption } in figures {
            let [title, caption] = [title, caption].map(|text| escaped(&text));
            self.raw(&format!(
                "<figure><h2>{title}</h2>\n{body}\n<figcaption>{caption}</figcaption></figure>"
            ));
        }
        self.raw("</div>");
    }

    /// Adds the facts that come first in the terminal as a table.
    pub(super) fn plain_facts(&mut self, rows: &AnswerRows) {
        self.table(rows.plain());
    }

    /// Adds a table of facts.
    pub(super) fn facts(&mut self, rows: &AnswerRows) {
        self.table(rows.of_page());
    }

    fn table<'a>(&mut self, facts: impl Iterator<Item = (&'a str, &'a str)>) {
        self.raw("<table>");
        for (name, sentence) in facts {
            let [name, sentence] = [name, sentence].map(escaped);
            self.raw(&format!("<tr><th scope=\"row\">{name}</th><td>{sentence}</td></tr>"));
        }
        self.raw("</table>");
    }

    /// Adds a table of facts with what each means, folded away.
    pub(super) fn folded_facts(&mut self, summary: &str, rows: &AnswerRows) {
        let rows: Vec<String> = rows.of_page().map(|(heading, sentence)| {
            let meaning = escaped(meaning(heading).unwrap_or(""));
            let [heading, sentence] = [heading, sentence].map(escaped);
            format!(
                "<tr><th scope=\"row\">{heading}</th><td>{sentence}</td><td class=\"meaning\">{meaning}</td></tr>\n"
            )
        }).collect();
        let summary = escaped(summary);
        self.raw(&format!(
            "<details><summary>{summary}</summary>\n<div class=\"wide\"><table>\n{}</table></div></details>",
            rows.concat()
        ));
    }

    /// Adds the tables that the terminal shows as lines.
    fn table_lines(&mut self, rows: &AnswerRows) {
        let lines: Vec<String> = rows.table_lines().map(escaped).collect();
        if !lines.is_empty() {
            self.raw(&format!("<pre class=\"wide\" tabindex=\"0\">{}</pre>", lines.join("\n")));
        }
    }

    /// Adds the files beside the page, with sizes and hashes.
    pub(super) fn files(&mut self, files: &[FileFacts]) {
        if files.is_empty() {
            return;
        }
        self.heading("Files");
        self.raw("<table>");
        for FileFacts { name, bytes, sha256, .. } in files {
            let (name, size) = (escaped(name), file_size(*bytes));
            self.raw(&format!(
                "<tr><th scope=\"row\"><a href=\"{name}\">{name}</a></th><td>{size} ({bytes} bytes)<br>\
                 <code>sha256 {sha256}</code></td></tr>"
            ));
        }
        self.raw("</table>");
    }

    /// Adds links to the pages of other commands that have an answer for the profile.
    pub(super) fn links(&mut self, own: &str, profile: &Profile) {
        self.heading("More about this mirror");
        self.raw("<table>");
        let name = escaped(&profile.name);
        let others = PAGES.iter().filter(|page| page.file != own && (page.suits)(profile));
        for CommandPage { file, answers, command, .. } in others {
            let command = command.replace("NAME", &name);
            self.raw(&format!(
                "<tr><th scope=\"row\"><a href=\"{file}\">{file}</a></th><td>{answers}: there after \
                 <code>morion {command}</code></td></tr>"
            ));
        }
        self.raw("</table>");
    }

    /// Adds a table of numbers; `names` may hold entities.
    pub(super) fn numbers(&mut self, names: &[&str], rows: impl IntoIterator<Item = Vec<String>>) {
        let names: Vec<String> =
            names.iter().map(|name| format!("<th scope=\"col\">{name}</th>")).collect();
        self.raw("<div class=\"wide\" tabindex=\"0\">");
        self.raw(&format!("<table class=\"n\">\n<thead><tr>{}</tr></thead>", names.concat()));
        for row in rows {
            let cells: Vec<String> =
                row.iter().map(|cell| format!("<td>{}</td>", escaped(cell))).collect();
            self.raw(&format!("<tr>{}</tr>", cells.concat()));
        }
        self.raw("</table></div>");
    }

    /// The whole page.
    pub(super) fn finish(mut self) -> String {
        self.raw("</main>\n</body></html>");
        self.html
    }
}

/// The page of an answer that is about `about`: reasons and warnings, facts in plain words, figures and tables; where
/// the pages of other commands lie in the folder of its file `own`, links to them.
pub(super) fn page_of(
    answer: &impl Answer,
    (own, about): (Option<(&str, &Profile)>, &str),
    figures: impl IntoIterator<Item = Figure>,
    files: &[FileFacts],
) -> String {
    let mut page = Page::new(answer, about);
    let head = answer.head();
    page.list(&head.reasons);
    page.warnings(head.warnings);
    let rows = answer.rows();
    page.plain_facts(&rows);
    page.figures(figures);
    page.table_lines(&rows);
    page.files(files);
    let details = rows.into_details();
    if details.of_page().next().is_some() {
        page.folded_facts("All figures, and what each means", &details);
    }
    if let Some((own, profile)) = own {
        page.links(own, profile);
    }
    page.finish()
}

/// A PNG as an image of the page, with what it shows for those who do not see it.
pub(super) fn image(png: &[u8], class: &str, alt: &str) -> String {
    let (data, alt) = (BASE64_STANDARD.encode(png), escaped(alt));
    format!("<img class=\"{class}\" src=\"data:image/png;base64,{data}\" alt=\"{alt}\">")
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

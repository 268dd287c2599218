//! A page as it is put together: sections with what they hold, and the data of the plots.

use serde_json::{Value, json};

use super::{
    chart::Chart,
    escape::escape,
    thinned::{Point, packed, packed_times},
};

/// A page in the making.
pub struct Page {
    title: String,
    head: String,
    sections: Vec<(String, String)>,
    data: Vec<Value>,
    /// Times of the lines that were not thinned, each once: most lines share theirs.
    times: Vec<Value>,
    /// Toolfaces over time.
    dial: Value,
    span: [f64; 2],
    /// Name and unit of what the plots are over.
    over: (&'static str, &'static str),
    /// Scripts of the page's own.
    scripts: String,
    /// True if its script asks the server that it is from for news.
    is_live: bool,
}

impl Page {
    /// An empty page. `span_s` is the time in seconds that every plot shows at first.
    #[must_use]
    pub fn new(title: &str, span_s: [f64; 2]) -> Self {
        Self::over(title, span_s, ("time", "s"))
    }

    /// An empty page whose plots are over something else than time: its span, name and unit.
    #[must_use]
    pub fn over(title: &str, span: [f64; 2], over: (&'static str, &'static str)) -> Self {
        Self {
            title: title.to_owned(),
            head: String::new(),
            sections: Vec::new(),
            data: Vec::new(),
            times: Vec::new(),
            dial: Value::Null,
            span,
            over,
            scripts: String::new(),
            is_live: false,
        }
    }

    /// Lets the page ask the server that it is from for [`Page::news`].
    pub fn live(&mut self) {
        self.is_live = true;
    }

    /// Adds to the first screen, before all sections.
    pub fn head(&mut self, html: &str) {
        self.head += html;
    }

    /// Begins a section; it is left out if nothing follows.
    pub fn section(&mut self, name: &str) {
        self.sections.push((name.to_owned(), String::new()));
    }

    /// Adds to the section that was begun last, or to the first screen.
    pub fn add(&mut self, html: &str) {
        match self.sections.last_mut() {
            Some((_, body)) => body.push_str(html),
            None => self.head += html,
        }
    }

    /// Adds a script, which runs when the page is there.
    pub fn script(&mut self, script: &str) {
        self.scripts += &format!("<script>\n{script}</script>\n");
    }

    /// Adds the toolface's dial, and the points in degrees from which the script draws it anew.
    pub(super) fn dial(&mut self, html: &str, points: &[Point]) {
        let toolface = packed(points.iter().map(|[_, degrees, _]| *degrees));
        self.dial =
            json!({ "t": packed_times(points, self.span[0]), "y": [toolface.middle, toolface.step, toolface.base64] });
        self.add(html);
    }

    /// Adds a plot; nothing if it would be empty.
    pub fn chart(&mut self, chart: Chart) {
        let Some((html, mut data)) = chart.drawn(self.data.len(), self.span, self.over) else { return };
        for series in data["series"].as_array_mut().into_iter().flatten() {
            let times = series["t"].take();
            if times.is_null() {
                continue;
            }
            let known = self.times.iter().position(|known| *known == times);
            series["t"] = known.unwrap_or(self.times.len()).into();
            if known.is_none() {
                self.times.push(times);
            }
        }
        self.data.push(data);
        self.add(&html);
    }

    /// Links to the sections, and the sections.
    fn body(&self) -> [String; 2] {
        let kept: Vec<_> = self.sections.iter().filter(|(_, body)| !body.is_empty()).enumerate().collect();
        let links = kept
            .iter()
            .map(|(number, (name, _))| format!("<a href=\"#section-{number}\">{}</a>\n", escape(name)))
            .collect();
        let sections = kept
            .iter()
            .map(|(number, (name, body))| {
                let name = escape(name);
                format!("<section aria-labelledby=\"section-{number}\">\n<h2 id=\"section-{number}\">{name}</h2>\n{body}</section>\n")
            })
            .collect();
        [links, sections]
    }

    /// Data of the plots.
    fn data(&self) -> Value {
        json!({ "span": self.span, "over": self.over.1, "times": self.times, "dial": self.dial, "charts": self.data })
    }

    /// Update that a page already shown takes over: head, links, sections and the data of the plots.
    #[must_use]
    pub fn news(&self) -> Value {
        let [links, sections] = self.body();
        json!({ "head": self.head, "links": links, "sections": sections, "data": self.data() })
    }

    /// The whole page, one file that needs nothing else and may load nothing.
    #[must_use]
    pub fn finish(self) -> String {
        let [links, sections] = self.body();
        let has_plots = self.is_live || !self.data.is_empty();
        let bar = if has_plots { include_str!("bar.html") } else { "" };
        let scripts = if has_plots {
            // A script ends at the first `</`, wherever it stands.
            let data = self.data().to_string().replace("</", "<\\/");
            format!(
                "<script type=\"application/json\" id=\"data\">{data}</script>\n<script>\n/* uPlot\n{}*/\n{}\n</script>\n<script>\n{}</script>\n",
                include_str!("vendor/uplot/LICENSE"),
                include_str!("vendor/uplot/uPlot.iife.min.js"),
                [include_str!("lines.js"), include_str!("page.js")].concat(),
            )
        } else {
            String::new()
        };
        let asks = if self.is_live { "; connect-src 'self'" } else { "" };
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta name=\"color-scheme\" content=\"light dark\"/>\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:{asks}\"/>\n\
             <title>{}</title>\n<style>\n{}\n{}</style>\n</head>\n<body>\n<main>\n<div id=\"head\">\n{}</div>\n\
             <nav aria-label=\"Sections\">\n{links}</nav>\n{bar}<div id=\"sections\">\n{sections}</div>\n</main>\n{scripts}{}</body>\n</html>\n",
            escape(&self.title),
            include_str!("vendor/uplot/uPlot.min.css"),
            include_str!("style.css"),
            self.head,
            self.scripts,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_without_anything_is_not_shown() {
        let mut page = Page::new("a", [0.0, 1.0]);
        page.section("Empty");
        page.section("Full");
        page.add("<p>what</p>");
        let page = page.finish();
        assert!(!page.contains("Empty") && page.matches(">Full<").count() == 2, "{page}");
        assert!(!page.contains("<script"), "no plot, no script");
    }
}

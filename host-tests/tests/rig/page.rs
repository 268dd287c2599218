//! Checks that an HTML page is well formed and needs nothing else.

/// The page without its scripts and styles, in which `<` is no tag.
pub fn without_scripts(page: &str) -> String {
    let mut page = page.to_owned();
    for tag in ["script", "style"] {
        let (opening, closing) = (format!("<{tag}"), format!("</{tag}>"));
        while let Some(start) = page.find(&opening) {
            let end = start + page[start..].find(&closing).unwrap() + closing.len();
            page.replace_range(start..end, "");
        }
    }
    page
}

/// Tags opened and not closed, or closed and not open.
pub fn unbalanced(page: &str) -> Vec<String> {
    let page = without_scripts(page);
    let mut open: Vec<&str> = Vec::new();
    let mut wrong = Vec::new();
    let body = page.strip_prefix("<!DOCTYPE html>").unwrap();
    for part in body.split('<').skip(1) {
        let Some((tag, _)) = part.split_once('>') else {
            wrong.push(part.to_owned());
            continue;
        };
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap();
        match (tag.starts_with('/'), tag.ends_with('/')) {
            (false, false) => open.push(name),
            (true, _) if open.pop() != Some(name) => wrong.push(tag.to_owned()),
            _ => {}
        }
    }
    wrong.extend(open.into_iter().map(str::to_owned));
    wrong
}

/// The page tells no figure that is none, asks for no other file, and may load none.
pub fn is_whole(page: &str) -> bool {
    let seen = without_scripts(page);
    let links = seen.split("href=\"").skip(1).all(|link| link.starts_with('#'));
    let nowhere = page.contains("Content-Security-Policy\" content=\"default-src 'none';");
    links
        && nowhere
        && !seen.contains("src=")
        && !seen.contains("<td>-</td>")
        && ![">NaN", "NaN ", ">inf", "inf "].iter().any(|x| seen.contains(x))
}

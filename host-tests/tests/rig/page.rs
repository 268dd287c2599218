//! Check that an HTML page is well formed.

/// Tags opened and not closed, or closed and not open.
pub fn unbalanced(page: &str) -> Vec<String> {
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

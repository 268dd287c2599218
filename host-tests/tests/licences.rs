//! Dependencies of the workspace come from the registry, under a licence that `deny.toml` allows; those that a vendor
//! links, under a permissive one. Needs no network, unlike `cargo deny`.
#![allow(clippy::unwrap_used, missing_docs)]

use mwd::target::{deadline, toolchain::workspace};
use std::{collections::BTreeSet, fs, process::Command, time::Duration};

/// Licences with a duty beyond naming the author.
const NOT_PERMISSIVE: [&str; 1] = ["MPL-2.0"];

/// Packages with their licences, as `cargo tree` prints them.
fn packages(arguments: &[&str]) -> BTreeSet<(String, String)> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut tree = Command::new(cargo);
    tree.current_dir(workspace()).args(["tree", "--locked", "--target=all", "--prefix=none", "--format={p}|{l}"]);
    let printed = deadline::run(tree.args(arguments), Duration::from_secs(120)).unwrap();
    let lines = printed.lines().filter(|line| !line.trim().is_empty());
    lines
        .map(|line| line.trim_end_matches(" (*)").split_once('|').unwrap())
        .map(|(p, l)| (p.into(), l.into()))
        .collect()
}

fn allowed() -> BTreeSet<String> {
    let deny: toml::Table = fs::read_to_string(workspace().join("deny.toml")).unwrap().parse().unwrap();
    let list = deny["licenses"]["allow"].as_array().unwrap();
    list.iter().map(|licence| licence.as_str().unwrap().to_owned()).collect()
}

/// Returns true if an SPDX expression allows a use under allowed licences. `AND` binds more closely than `OR`; a slash
/// is an old `OR`.
fn fits(expression: &str, allowed: &dyn Fn(&str) -> bool) -> bool {
    let expression = expression.replace(" / ", " OR ").replace('/', " OR ");
    if let Some((inside, rest)) = expression.strip_prefix('(').and_then(|rest| rest.split_once(')')) {
        return match rest.trim().split_once(' ') {
            Some(("AND", other)) => fits(inside, allowed) && fits(other, allowed),
            Some((_, other)) => fits(inside, allowed) || fits(other, allowed),
            None => fits(inside, allowed),
        };
    }
    expression.split(" OR ").any(|all| all.split(" AND ").all(|one| allowed(one.trim())))
}

#[test]
fn every_licence_is_allowed_and_a_vendors_are_permissive() {
    let allowed = allowed();
    let all = packages(&["--workspace", "--all-features"]);
    assert!(all.len() > 100, "{}", all.len());
    for (package, licence) in &all {
        assert!(fits(licence, &|one| allowed.contains(one)), "{package}: {licence}");
        assert!(!package.contains("git+") && !package.contains("(http"), "{package}: not from the registry");
    }
    let permissive = |one: &str| allowed.contains(one) && !NOT_PERMISSIVE.contains(&one);
    let linked = packages(&["-p", "meerkat-mwd", "-p", "meerkat-mwd-c", "--all-features", "--edges=normal"]);
    assert!(linked.len() > 20 && linked.len() < all.len());
    for (package, licence) in &linked {
        assert!(fits(licence, &permissive), "{package}: {licence}");
    }
}

#[test]
fn an_expression_is_read_as_spdx_says() {
    let mit = |one: &str| one == "MIT";
    assert!(fits("MIT", &mit) && fits("Apache-2.0/MIT", &mit) && fits("(MIT OR X)", &mit));
    assert!(!fits("MIT AND X", &mit) && !fits("(MIT OR X) AND Y", &mit) && fits("X AND Y OR MIT", &mit));
}

//! Selection of the surveys' tests: whether the tool stands still.
#![allow(dead_code)]

#[path = "../../../tests/survey/interlock.rs"]
mod interlock;
#[path = "../../../tests/survey/tool.rs"]
mod tool;

#![doc = include_str!("../docs/equations.md")]

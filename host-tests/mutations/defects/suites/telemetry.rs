//! Of the tests of the line: what the gate lets through, and what waits for the line.
#![allow(dead_code)]

#[path = "../../../tests/telemetry/commands.rs"]
mod commands;
#[path = "../../../tests/telemetry/frames.rs"]
mod frames;
#[path = "../../../tests/telemetry/queue.rs"]
mod queue;

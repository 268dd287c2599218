//! Selection of the line's tests: commands that the gate lets through, and messages that wait for the line.
#![allow(dead_code)]

#[path = "../../../tests/telemetry/commands.rs"]
mod commands;
#[path = "../../../tests/telemetry/frames.rs"]
mod frames;
#[path = "../../../tests/telemetry/queue.rs"]
mod queue;

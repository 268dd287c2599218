use ratatui::{
    Frame,
    layout::{Constraint, Layout},
    style::{Color, Modifier, Style},
    symbols::Marker,
    text::Line,
    widgets::{
        Block, Paragraph, Wrap,
        canvas::{Canvas, Circle, Line as Stroke},
    },
};

use meerkat_mwd::survey::Grade;

use super::{
    state::State,
    summary::{
        angles_text, burst_text, diagnosis_text, dose_text, dynamics_text, grade_text, health_text, magnet_text,
        model_text, sliding_text, survey_text, toolface,
    },
};

/// Draws the toolface dial on the left and the reports in words beside it.
pub fn draw(frame: &mut Frame<'_>, state: &State) {
    let [dial, words] = Layout::horizontal([Constraint::Length(34), Constraint::Min(30)]).areas(frame.area());
    let [dial, _] = Layout::vertical([Constraint::Length(17), Constraint::Min(0)]).areas(dial);
    let angles = state.attitude.as_ref().and_then(|attitude| attitude.angles.as_ref());
    let (title, pointer) = match angles.map(toolface) {
        Some((kind, angle)) => (format!(" {kind} toolface {:.1} deg ", angle.to_degrees()), Some(f64::from(angle))),
        None => (" toolface ".to_owned(), None),
    };
    let canvas = Canvas::default()
        .block(Block::bordered().title(title))
        .marker(Marker::Braille)
        .x_bounds([-1.3, 1.3])
        .y_bounds([-1.3, 1.3])
        .paint(move |canvas| {
            canvas.draw(&Circle { x: 0.0, y: 0.0, radius: 1.0, color: Color::Gray });
            for (label, turn) in [("0", 0.0), ("90", 0.25), ("180", 0.5), ("270", 0.75_f64)] {
                let (x, y) = on_dial(turn * std::f64::consts::TAU, 1.18);
                canvas.print(x - 0.04 * label.len() as f64, y, label);
            }
            if let Some(angle) = pointer {
                let (x, y) = on_dial(angle, 0.9);
                canvas.draw(&Stroke { x1: 0.0, y1: 0.0, x2: x, y2: y, color: Color::Yellow });
            }
        });
    frame.render_widget(canvas, dial);

    let bold = Style::new().add_modifier(Modifier::BOLD);
    let mut lines = vec![Line::styled(format!("t {:.1} s", state.t_us as f64 * 1e-6), bold)];
    match angles {
        Some(angles) => lines.extend(angles_text(angles).into_iter().map(|text| Line::styled(text, bold))),
        None => lines.push(Line::styled("no attitude yet", bold)),
    }
    let mut section = |name: &'static str, text: String, style: Style| {
        lines.push(Line::default());
        lines.push(Line::styled(name, Style::new().fg(Color::DarkGray)));
        lines.push(Line::styled(text, style));
    };
    if let Some(report) = &state.survey {
        let colour = match report.quality.grade {
            Grade::Good => Color::Green,
            Grade::Doubtful => Color::Yellow,
            _ => Color::Red,
        };
        section("survey", survey_text(report), Style::new());
        section("quality", grade_text(report.quality.grade).to_owned(), Style::new().fg(colour));
    }
    if let Some(toolface) = &state.toolface {
        section("sliding", sliding_text(toolface), Style::new());
    }
    if let Some(dynamics) = &state.dynamics {
        section("drilling", dynamics_text(dynamics), Style::new());
    }
    if let Some(dose) = &state.dose {
        section("dose", dose_text(dose), Style::new());
    }
    if let Some(burst) = burst_text(state) {
        section("burst", burst, Style::new());
    }
    section("model", model_text(state), Style::new());
    if let Some(report) = &state.diagnosis {
        section("diagnosis", diagnosis_text(report), Style::new());
    }
    if let Some(interval) = &state.hard_iron {
        section("magnet", magnet_text(interval), Style::new());
    }
    if let Some(health) = &state.health {
        section("health", health_text(health), Style::new());
    }
    let link = state.link;
    section(
        "link",
        format!("{} frames, {} damaged, {} missing; q ends", link.frames, link.bad, link.lost),
        Style::new(),
    );
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }).block(Block::bordered()), words);
}

/// A point on the dial: 0 on top, clockwise looking down-hole.
fn on_dial(angle_rad: f64, radius: f64) -> (f64, f64) {
    (radius * angle_rad.sin(), radius * angle_rad.cos())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use meerkat_mwd::{
        attitude::{Attitude, AttitudeFlags},
        probe::Output,
        telemetry::Message,
    };
    use ratatui::{Terminal, backend::TestBackend};

    use super::*;

    /// Ends of the pointer's strokes for a toolface, from the dial's middle.
    fn pointer(toolface_deg: f32) -> (f64, f64) {
        let attitude = Attitude {
            q: [1.0, 0.0, 0.0, 0.0],
            inclination_rad: 1.0,
            azimuth_rad: 2.0,
            gravity_toolface_rad: toolface_deg.to_radians(),
            magnetic_toolface_rad: 0.0,
            sigma_inclination_rad: 0.01,
            sigma_azimuth_rad: 0.02,
            sigma_toolface_rad: 0.03,
            flags: AttitudeFlags::empty(),
        };
        let mut state = State::default();
        state.take(Message::Output(Output { t_us: 1_000_000, rate_rad_s: [0.0; 3], attitude: Some(attitude) }));
        let mut terminal = Terminal::new(TestBackend::new(110, 40)).unwrap();
        terminal.draw(|frame| draw(frame, &state)).unwrap();
        let buffer = terminal.backend().buffer();
        let text: String = buffer.content().iter().map(ratatui::buffer::Cell::symbol).collect();
        // 1 and 2 rad, to the sixteen bits of an attitude frame.
        assert!(text.contains("inclination 57.29 ") && text.contains("azimuth 114.59 "), "{text}");
        let (mut x, mut y, mut count) = (0.0, 0.0, 0.0);
        for row in 1..16 {
            for column in 1..33 {
                if buffer[(column, row)].fg == Color::Yellow {
                    x += f64::from(column) - 16.5;
                    y += 2.0 * (8.0 - f64::from(row));
                    count += 1.0;
                }
            }
        }
        assert!(count > 3.0);
        (x / count, y / count)
    }

    #[test]
    fn the_pointer_turns_clockwise_from_the_top() {
        for toolface_deg in (0..360).step_by(30) {
            let (x, y) = pointer(toolface_deg as f32);
            let seen = x.atan2(y).to_degrees().rem_euclid(360.0);
            let apart = (seen - f64::from(toolface_deg) + 180.0).rem_euclid(360.0) - 180.0;
            assert!(apart.abs() < 15.0, "{toolface_deg} is drawn at {seen}");
        }
    }
}

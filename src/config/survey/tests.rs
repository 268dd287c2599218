use super::*;

#[test]
fn the_default_is_valid_and_a_bad_field_is_named() {
    assert_eq!(SurveyConfig::default().validate(), Ok(()));
    let named = |change: fn(&mut SurveyConfig)| {
        let mut config = SurveyConfig::default();
        change(&mut config);
        config.validate().map_err(|error| error.field)
    };
    assert_eq!(named(|c| c.rotating_turns = 2), Err("survey.rotating_turns"));
    assert_eq!(named(|c| c.toolface_offset_rad = f32::NAN), Err("survey.toolface_offset_rad"));
    assert_eq!(named(|c| c.errors.mag_bias_ut = -1.0), Err("survey.errors.mag_bias_ut"));
    assert_eq!(named(|c| c.limits.bad_over_limit = 0.5), Err("survey.limits.bad_over_limit"));
    assert_eq!(named(|c| c.dynamics.window_s = 0.1), Err("survey.dynamics.window_s"));
}

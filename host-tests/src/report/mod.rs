//! Reports of a flight for a user: summary, account of the diagnosis, JSON, CSV and pages.

pub mod account;
pub mod attitude_at_end;
pub mod attitude_csv;
pub mod effect_words;
pub mod explanation;
pub mod field_unused;
pub mod flight_notes;
pub mod hidden_in_p_b;
pub mod html;
pub mod json;
pub mod motion;
pub mod picture;
pub mod plain_words;
pub mod rates_csv;
pub mod refusal_text;
pub mod remainder_text;
pub mod summary;
pub mod surveys_csv;
mod toolface;
pub mod turned_axes;
pub mod dynamics_csv;
pub mod window_note;

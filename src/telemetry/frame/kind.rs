//! Kinds of frames and their numbers on the line.

/// Kind of a frame. The numbers are part of the protocol: none is ever given to another kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
#[non_exhaustive]
#[repr(u8)]
pub enum Kind {
    /// State that the probe started with: [`Boot`](crate::telemetry::Boot). The sequence numbers of a probe begin
    /// anew with it.
    Boot = 1,
    /// Angles of one sample, quantised: [`AttitudeFrame`](crate::telemetry::AttitudeFrame).
    Attitude = 2,
    /// All bits of one sample's output: [`Output`](crate::probe::Output).
    Output = 3,
    /// One raw sample: [`RawSample`](crate::telemetry::RawSample).
    Sample = 4,
    /// A survey: [`SurveyReport`](crate::survey::SurveyReport).
    Survey = 5,
    /// A window of drilling dynamics: [`DrillingDynamics`](crate::survey::DrillingDynamics).
    Dynamics = 6,
    /// Result of a window: [`Identification`](crate::telemetry::Identification).
    Identification = 7,
    /// Effects and verdict: [`DiagnosisReport`](crate::diagnosis::DiagnosisReport).
    Diagnosis = 8,
    /// A magnet: [`HardIronInterval`](crate::magnet::HardIronInterval).
    HardIron = 9,
    /// Counters, stack, overruns: [`Health`](crate::telemetry::Health).
    Health = 10,
    /// Answer to a command.
    Acknowledgement = 11,
    /// A toolface while sliding: [`SlidingToolface`](crate::survey::SlidingToolface).
    Toolface = 12,
    /// Vibration and shocks so far: [`VibrationDose`](crate::survey::VibrationDose).
    Dose = 13,
    /// Part of the raw samples of the second with the most vibration: [`BurstPart`](crate::telemetry::BurstPart).
    Burst = 14,
    /// The program that runs, on a probe that takes another over the line:
    /// [`ProgramReport`](crate::telemetry::ProgramReport).
    Program = 15,
    /// To the probe: a command that anybody may give.
    Command = 64,
    /// To the probe: a command with counter and authentication.
    AuthenticatedCommand = 65,
    /// To the probe: bytes of a program's image, [`ImagePart`](crate::telemetry::ImagePart). One that was not announced
    /// by a command with the key is ignored.
    ImagePart = 66,
}

impl Kind {
    /// Returns the kind of a number; `None` for another version's.
    #[must_use]
    pub const fn of_number(number: u8) -> Option<Self> {
        Some(match number {
            1 => Self::Boot,
            2 => Self::Attitude,
            3 => Self::Output,
            4 => Self::Sample,
            5 => Self::Survey,
            6 => Self::Dynamics,
            7 => Self::Identification,
            8 => Self::Diagnosis,
            9 => Self::HardIron,
            10 => Self::Health,
            11 => Self::Acknowledgement,
            12 => Self::Toolface,
            13 => Self::Dose,
            14 => Self::Burst,
            15 => Self::Program,
            64 => Self::Command,
            65 => Self::AuthenticatedCommand,
            66 => Self::ImagePart,
            _ => return None,
        })
    }

    /// Returns the kind's number on the line.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }
}

#[cfg(test)]
mod tests;

//! What a fit has to say against itself.

use serde::Serialize;
use support::metrics::Quality;

use super::physical::AtBound;

/// One thing that keeps the coefficients from being what they look like.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Warning {
    /// Which.
    pub kind: Kind,
    /// What it is and what would mend it, in one line.
    pub text: String,
}

/// Kinds of warnings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A parameter is at the end of what a motor or a wheel can be: the data do not determine it.
    AtBound,
    /// The search did not end at a minimum.
    NotConverged,
    /// The search was cut short: no minimum was in reach.
    LongSearch,
    /// The mean power of the rows predicts them better.
    WorseThanMean,
    /// A log looks like another one than its columns say.
    SuspectLog,
    /// Boards refuse coefficients whose power no robot draws, and those that need a gyro.
    NotForBoards,
}

impl Warning {
    /// A parameter at its bound.
    pub fn at_bound(at: &AtBound) -> Self {
        let AtBound { description, bound, of_motor } = at;
        let whose = if *of_motor { "this robot's motor" } else { "a motor or a wheel" };
        let text = format!(
            "{} is at its bound of {bound:.3e} {}, the end of what {whose} can be: these runs do not determine it; {}",
            description.name,
            description.unit,
            at.remedy()
        );
        Self { kind: Kind::AtBound, text }
    }

    /// A further term that ended at its bound.
    pub(super) fn left_out(at: &AtBound) -> Self {
        let text = format!(
            "{} ended at its bound and was left out: these runs do not determine it; {}",
            at.description.name,
            at.remedy()
        );
        Self { kind: Kind::AtBound, text }
    }

    pub(super) fn not_converged(ending: &str) -> Self {
        let text = format!(
            "the search ended as {ending}, not at a minimum: the coefficients are the best that were met; more rows, speeds and \
             payloads determine them better"
        );
        Self { kind: Kind::NotConverged, text }
    }

    pub(super) fn long_search(steps: u32) -> Self {
        let text = format!(
            "the search was cut short after {steps} steps, where logs of robots take 3,200 at most: wheels that turn so draw no such \
             power; no residual counts linearly, and further terms may not have been asked; look at the log first (gmr inspect): its \
             clock, the sign and unit of power and speeds"
        );
        Self { kind: Kind::LongSearch, text }
    }

    pub(super) fn of_log(text: String) -> Self {
        Self { kind: Kind::SuspectLog, text }
    }

    /// True slip was taken.
    pub(super) fn needs_gyro() -> Self {
        let text =
            "no board would take these coefficients: true slip needs a gyro; gmr fit --no-gyro does without";
        Self { kind: Kind::NotForBoards, text: text.to_owned() }
    }

    pub(super) fn not_for_boards() -> Self {
        let text = "no board takes these coefficients: their power at ordinary speed and mass is one that no robot has; drive at \
                    more speeds, turns and payloads"
            .to_owned();
        Self { kind: Kind::NotForBoards, text }
    }
}

/// What the errors on the fitted rows say.
pub(super) fn of_quality(quality: &Quality) -> Option<Warning> {
    let r2 = quality.r2.filter(|r2| *r2 < 0.0)?;
    let text = format!(
        "R² is {r2:.3}: the mean power of these rows predicts them better than the model; look at the log first (gmr inspect): its \
         clock, the sign and unit of power and speeds, which power it is"
    );
    Some(Warning { kind: Kind::WorseThanMean, text })
}

//! Kinds of drives, as the speeds that are asked for.

use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Length of a drive, s.
pub(crate) const DURATION_S: u32 = 100;

/// The robot's limits: m/s and rad/s.
const SPEED: f64 = 0.22;
const TURN: f64 = 2.84;

/// A kind of drive.
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    legs: fn(&mut Rng) -> Leg,
}

/// Up to a speed, and on for a while.
struct Leg {
    /// m/s and rad/s.
    twist: [f64; 2],
    ramp_s: f64,
    hold_s: f64,
}

impl Leg {
    fn new(speed: f64, turn: f64, ramp_s: f64, hold_s: f64) -> Self {
        Self { twist: [SPEED * speed, TURN * turn], ramp_s, hold_s }
    }
}

pub(crate) const KINDS: [Kind; 14] = [
    Kind {
        name: "straight only",
        legs: |r| Leg::new(r.within(0.1, 1.0), 0.0, r.within(0.3, 1.5), r.within(1.0, 4.0)),
    },
    Kind {
        name: "turns only",
        legs: |r| Leg::new(0.0, r.sign() * r.within(0.1, 0.5), r.within(0.3, 1.5), r.within(1.0, 4.0)),
    },
    Kind {
        name: "curves",
        legs: |r| {
            let turn = r.sign() * r.within(0.05, 0.25);
            Leg::new(r.within(0.3, 0.8), turn, r.within(0.5, 2.0), r.within(2.0, 5.0))
        },
    },
    Kind {
        name: "crawling",
        legs: |r| Leg::new(r.within(0.04, 0.16), r.sign() * r.within(0.0, 0.02), 0.5, r.within(1.0, 4.0)),
    },
    Kind {
        name: "jerky",
        legs: |r| Leg::new(r.within(-1.0, 1.0), r.sign() * r.within(0.0, 0.1), 0.15, r.within(0.2, 0.8)),
    },
    Kind {
        name: "stop and go",
        legs: |r| {
            let go = if r.within(0.0, 1.0) < 0.5 { 0.0 } else { r.within(0.3, 1.0) };
            Leg::new(go, 0.0, r.within(0.3, 0.8), r.within(0.5, 2.5))
        },
    },
    Kind { name: "long legs", legs: |r| Leg::new(r.within(0.3, 1.0), 0.0, 1.0, r.within(8.0, 15.0)) },
    Kind {
        name: "shunting",
        legs: |r| Leg::new(r.sign() * r.within(0.4, 1.0), 0.0, r.within(0.5, 1.0), r.within(0.5, 2.0)),
    },
    Kind { name: "weaving", legs: |r| Leg::new(0.6, r.sign() * r.within(0.1, 0.2), 0.6, 0.2) },
    Kind { name: "surging", legs: |r| Leg::new(r.within(0.3, 1.0), 0.0, r.within(1.5, 3.0), 0.0) },
    Kind {
        name: "dashes",
        legs: |r| Leg::new(if r.within(0.0, 1.0) < 0.5 { 0.1 } else { 1.0 }, 0.0, 0.45, r.within(0.5, 2.0)),
    },
    Kind {
        name: "mostly at rest",
        legs: |r| {
            let (go, hold) =
                if r.within(0.0, 1.0) < 0.5 { (0.0, r.within(4.0, 8.0)) } else { (r.within(0.4, 1.0), 2.0) };
            Leg::new(go, 0.0, 0.6, hold)
        },
    },
    Kind {
        name: "full speed",
        legs: |r| Leg::new(r.within(0.85, 1.0), r.sign() * r.within(0.0, 0.02), 0.5, r.within(1.0, 4.0)),
    },
    Kind {
        name: "mixed",
        legs: |r| {
            let turn = r.sign() * r.within(0.0, 0.3);
            let speed = r.within(-0.8, 0.9) * (1.0 - 2.0 * f64::abs(turn));
            Leg::new(speed, turn, r.within(0.3, 2.0), r.within(0.3, 4.0))
        },
    },
];

impl Kind {
    /// Writes a profile of this kind for `gmr simulate`.
    pub(crate) fn write(&self, folder: &Path, seed: u64) -> PathBuf {
        let mut rng = Rng(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let mut text = "time_s,v_m_s,omega_rad_s\n0,0,0\n1,0,0\n".to_owned();
        let mut time = 1.0;
        while time < f64::from(DURATION_S) {
            let Leg { twist: [v, omega], ramp_s, hold_s } = (self.legs)(&mut rng);
            for step in [ramp_s, hold_s].into_iter().filter(|step| *step > 0.0) {
                time += step;
                writeln!(text, "{time:.4},{v:.5},{omega:.5}").expect("text");
            }
        }
        let file = folder.join("profile.csv");
        std::fs::write(&file, text).expect("a profile is written");
        file
    }
}

/// SplitMix64.
pub(crate) struct Rng(u64);

impl Rng {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn sign(&mut self) -> f64 {
        if self.within(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 }
    }
}

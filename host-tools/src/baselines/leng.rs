//! Leng 2024: multivariate linear regression on the body's motion (Eq. 30), and with the mass of Parasuraman 2014 (Eq. 31).

use super::regression::Regression;
use super::{Card, Point};

/// Eq. 31, the regression that the paper compares itself with.
pub const WITH_MASS: Card = Card {
    name: "linear",
    source: "Leng 2024 with the mass of Parasuraman 2014 (Eq. 31): linear in v, ω, gated v̇ v and ω̇ ω, and m",
    assumes: "level ground; a kilogram costs the same power at any speed",
    takes_mass: true,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Regression::new("linear", WITH_MASS_SYMBOLS, with_mass)),
};

const WITH_MASS_SYMBOLS: [(&str, &str); 8] = [
    ("c0", "W"),
    ("c1", "W s/m"),
    ("c2", "W s³/m²"),
    ("c3", "W s³/m²"),
    ("c4", "W s"),
    ("c5", "W s³"),
    ("c6", "W s³"),
    ("c7", "W/kg"),
];

/// 1, v, max(v̇, 0) v, min(v̇, 0) v, ω, max(ω̇, 0) ω, min(ω̇, 0) ω, m.
fn with_mass(point: &Point) -> [f64; 8] {
    let (v, omega) = (point.speed.vx, point.speed.omega);
    let (dv, domega) = (point.acceleration.vx, point.acceleration.omega);
    [
        1.0,
        v,
        dv.max(0.0) * v,
        dv.min(0.0) * v,
        omega,
        domega.max(0.0) * omega,
        domega.min(0.0) * omega,
        point.mass,
    ]
}

#[cfg(test)]
mod tests {
    use super::WITH_MASS;
    use crate::baselines::testing::{drive, recovers};

    /// Data made by Eq. 31 itself give its coefficients back.
    #[test]
    fn recovers_its_own_coefficients() {
        let truth = [0.3, 2.0, 5.0, -1.0, 0.4, 0.7, -0.2, 0.05];
        let points = drive(2000, |point| {
            let (v, omega) = (point.speed.vx, point.speed.omega);
            let (dv, domega) = (point.acceleration.vx, point.acceleration.omega);
            let gated = |rate: f64, speed: f64, up: f64, down: f64| {
                if rate > 0.0 { up * rate * speed } else { down * rate * speed }
            };
            truth[0]
                + truth[1] * v
                + gated(dv, v, truth[2], truth[3])
                + truth[4] * omega
                + gated(domega, omega, truth[5], truth[6])
                + truth[7] * point.mass
        });
        recovers(&WITH_MASS, &points, &truth, 1e-9);
    }
}

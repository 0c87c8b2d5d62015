//! Wheel speeds to body motion: ζ = R w (Section 4.4), and the mass matrix at the wheels, M'' of
//! Eq. 18.

use crate::real::Real;
use crate::slip::Rims;

/// Motion of the body in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist<T> {
    /// Forward speed, m/s.
    pub vx: T,
    /// Speed to the left, m/s; 0 where the wheels cannot move the robot sideways.
    pub vy: T,
    /// Turn rate, counter-clockwise from above, rad/s.
    pub omega: T,
}

/// A length that no robot can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InvalidLength {
    /// Which one; it has to be finite and above zero.
    pub name: &'static str,
}

/// The matrix R, rows vx, vy (m) and ω (dimensionless), one column a wheel. Positive wheel speed
/// drives forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kinematics<T, const N: usize> {
    rows: [[T; N]; 3],
    scrubs: bool,
}

fn length<T: Real>(name: &'static str, value: T) -> Result<T, InvalidLength> {
    if value.is_finite() && value > T::ZERO { Ok(value) } else { Err(InvalidLength { name }) }
}

impl<T: Real> Kinematics<T, 2> {
    /// Differential drive, wheels left and right, `track` apart (m). Also skid steer with one wheel
    /// speed a side and the effective track.
    ///
    /// # Errors
    /// Names a length that is not finite and positive.
    pub fn differential(wheel_radius: T, track: T) -> Result<Self, InvalidLength> {
        let r = length("wheel_radius_m", wheel_radius)?;
        let track = length("track_m", track)?;
        let v = r * T::HALF;
        let o = r / track;
        Ok(Self { rows: [[v, v], [T::ZERO; 2], [-o, o]], scrubs: false })
    }
}

impl<T: Real> Kinematics<T, 4> {
    /// Skid steer with four driven wheels: front left, front right, rear left, rear right;
    /// effective track in m.
    ///
    /// # Errors
    /// Names a length that is not finite and positive.
    pub fn skid_steer(wheel_radius: T, track: T) -> Result<Self, InvalidLength> {
        let r = length("wheel_radius_m", wheel_radius)?;
        let track = length("track_m", track)?;
        let v = r * T::HALF * T::HALF;
        let o = r * T::HALF / track;
        Ok(Self { rows: [[v; 4], [T::ZERO; 4], [-o, o, -o, o]], scrubs: true })
    }

    /// Four mecanum wheels (rollers at 45°, seen from above forming an X): front left, front right,
    /// rear left, rear right, at `half_length` ahead and `half_width` aside of the centre (m).
    ///
    /// # Errors
    /// Names a length that is not finite and positive.
    pub fn mecanum(wheel_radius: T, half_length: T, half_width: T) -> Result<Self, InvalidLength> {
        let r = length("wheel_radius_m", wheel_radius)?;
        let arm = length("half_length_m", half_length)? + length("half_width_m", half_width)?;
        let v = r * T::HALF * T::HALF;
        let o = v / arm;
        Ok(Self { rows: [[v; 4], [-v, v, v, -v], [-o, o, -o, o]], scrubs: false })
    }
}

impl<T: Real> Kinematics<T, 3> {
    /// Three omni wheels at 60°, 180° and 300° from the front, counter-clockwise (front left, rear,
    /// front right), each `arm` (m) from the centre; all positive turns the robot
    /// counter-clockwise.
    ///
    /// # Errors
    /// Names a length that is not finite and positive.
    pub fn omni(wheel_radius: T, arm: T) -> Result<Self, InvalidLength> {
        let r = length("wheel_radius_m", wheel_radius)?;
        let arm = length("arm_m", arm)?;
        let third = r / T::from_f64(3.0);
        let side = r / T::from_f64(3.0).sqrt();
        let o = third / arm;
        Ok(Self { rows: [[-side, T::ZERO, side], [third, -(T::TWO * third), third], [o; 3]], scrubs: false })
    }
}

impl<T: Real, const N: usize> Kinematics<T, N> {
    /// A given matrix, rows vx, vy (m) and ω (dimensionless).
    ///
    /// # Errors
    /// An entry that is not finite, or a matrix of zeros.
    pub fn from_rows(rows: [[T; N]; 3]) -> Result<Self, InvalidLength> {
        let mut any = false;
        for entry in rows.iter().flatten() {
            if !entry.is_finite() {
                return Err(InvalidLength { name: "matrix" });
            }
            any |= *entry != T::ZERO;
        }
        if any { Ok(Self { rows, scrubs: false }) } else { Err(InvalidLength { name: "matrix" }) }
    }

    /// The same wheels, whether or not they are dragged sideways in turns, as those of skid steer
    /// are.
    #[must_use]
    pub fn with_scrub(self, scrubs: bool) -> Self {
        Self { scrubs, ..self }
    }

    /// Whether the wheels are dragged sideways in turns.
    pub fn scrubs(&self) -> bool {
        self.scrubs
    }

    /// The matrix R, rows vx, vy (m) and ω (dimensionless).
    pub fn rows(&self) -> &[[T; N]; 3] {
        &self.rows
    }

    /// ζ = R w for wheel speeds in rad/s.
    #[inline]
    pub fn twist(&self, wheel_speed: &[T; N]) -> Twist<T> {
        let [vx, vy, omega] = self.rows.map(|row| dot(&row, wheel_speed));
        Twist { vx, vy, omega }
    }

    /// By how much the sides' mean wheel speeds differ (right less left, rad/s) for each rad/s that
    /// the robot turns, where nothing slips: of a robot with two sides the track over the wheels'
    /// radius.
    pub fn difference_per_turn(&self) -> T {
        let [_, _, omega] = &self.rows;
        T::TWO / omega.iter().fold(T::ZERO, |sum, entry| sum + entry.abs())
    }

    /// M'' = Rᵀ diag(1, 1, k²) R (m²) for the radius of gyration k (m) about the vertical axis.
    ///
    /// # Errors
    /// A radius that is not finite and positive.
    pub fn mass_matrix(&self, gyration_radius: T) -> Result<MassMatrix<T, N>, InvalidLength> {
        let k = length("gyration_radius_m", gyration_radius)?;
        let [vx, vy, omega] = &self.rows;
        let mut rows = [[T::ZERO; N]; N];
        let columns = vx.iter().zip(vy).zip(omega);
        for (row, ((xi, yi), oi)) in rows.iter_mut().zip(columns.clone()) {
            for (entry, ((xj, yj), oj)) in row.iter_mut().zip(columns.clone()) {
                *entry = *xi * *xj + *yi * *yj + *oi * *oj * (k * k);
            }
        }
        let most = omega.iter().fold(T::ZERO, |most, entry| most.at_least(entry.abs()));
        let turn = omega.map(|entry| if self.scrubs && most > T::ZERO { entry / most } else { T::ZERO });
        let sides = self.sides();
        Ok(MassMatrix {
            rows,
            turn,
            scrubs: self.scrubs,
            sides: sides.unwrap_or(Sides::NONE),
            two_sided: sides.is_some(),
        })
    }

    /// The two sides of differential drive and skid steer. `None` for wheels that move the robot
    /// sideways, for one that has no part in driving ahead or in turning, and for wheels all on one
    /// side.
    pub fn sides(&self) -> Option<Sides<T, N>> {
        let [vx, vy, omega] = &self.rows;
        let most = omega.iter().fold(T::ZERO, |most, entry| most.at_least(entry.abs()));
        let (mut left, mut right) = (T::ZERO, T::ZERO);
        let mut sides =
            Sides { side: [T::ZERO; N], turn: omega.map(|entry| entry / most), weight: [T::ZERO; N] };
        for (((side, forward), sideways), turn) in sides.side.iter_mut().zip(vx).zip(vy).zip(omega) {
            // Forward turning wheels on the left turn the robot clockwise: their entry is negative.
            *side = (*forward * *turn).sign();
            if *sideways != T::ZERO || *side == T::ZERO {
                return None;
            }
            let count = if *side > T::ZERO { &mut right } else { &mut left };
            *count += T::ONE;
        }
        if left == T::ZERO || right == T::ZERO {
            return None;
        }
        for ((weight, side), forward) in sides.weight.iter_mut().zip(&sides.side).zip(vx) {
            *weight = forward.sign() / if *side > T::ZERO { right } else { left };
        }
        Some(sides)
    }
}

/// The two sides of a robot that turns by a difference of their wheels' speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sides<T, const N: usize> {
    /// −1 for wheels on the left, 1 for those on the right.
    side: [T; N],
    /// Row ω of R over its largest entry.
    turn: [T; N],
    /// What a wheel's speed adds to the mean of its side.
    weight: [T; N],
}

impl<T: Real, const N: usize> Sides<T, N> {
    const NONE: Self = Self { side: [T::ZERO; N], turn: [T::ZERO; N], weight: [T::ZERO; N] };

    /// How both sides turn at these wheel speeds, `rest` being the dead band (rad/s).
    #[inline]
    pub fn rims(&self, wheel_speed: &[T; N], rest: T) -> Rims<T> {
        let (mut difference, mut sum) = (T::NOTHING, T::NOTHING);
        for ((side, weight), speed) in self.side.iter().zip(&self.weight).zip(wheel_speed) {
            let weighted = *weight * *speed;
            sum += weighted;
            difference += *side * weighted;
        }
        Rims { difference, mean: (sum * T::HALF).abs(), rest }
    }

    /// σ of each wheel where the share `slip` (−1 … 1) of the turn's scrub is there.
    #[inline]
    pub fn scrub(&self, slip: T) -> [T; N] {
        self.turn.map(|share| share * slip)
    }
}

/// M'' of Eq. 18: inertia at the wheels per kilogram of robot, m².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassMatrix<T, const N: usize> {
    rows: [[T; N]; N],
    /// Row ω of R over its largest entry where the wheels scrub; zeros where they do not.
    turn: [T; N],
    scrubs: bool,
    sides: Sides<T, N>,
    two_sided: bool,
}

impl<T: Real, const N: usize> MassMatrix<T, N> {
    /// −1 for wheels on the left, 1 for those on the right; zeros where the robot has no two sides.
    #[inline]
    pub fn side(&self) -> &[T; N] {
        &self.sides.side
    }

    /// The two sides, where the robot has two.
    #[inline]
    pub fn sides(&self) -> Option<&Sides<T, N>> {
        self.two_sided.then_some(&self.sides)
    }

    /// Whether wheels are dragged sideways in turns.
    #[inline]
    pub(crate) fn scrubs(&self) -> bool {
        self.scrubs
    }

    /// K = M'' a: inertial torque at each wheel per kilogram (N·m/kg) for wheel accelerations in
    /// rad/s².
    #[inline]
    pub fn torque_per_kg(&self, wheel_acceleration: &[T; N]) -> [T; N] {
        let mut torque = [T::ZERO; N];
        for (out, row) in torque.iter_mut().zip(&T::read(&self.rows)) {
            *out = dot(row, wheel_acceleration);
        }
        torque
    }

    /// σ: the share of each wheel in overcoming the scrub of a turn, signed so that σ_i w_i is work
    /// done; zeros where the wheels do not scrub or the robot turns by less than `dead_band` (rad/s
    /// at the outermost wheels).
    #[inline]
    pub fn scrub(&self, wheel_speed: &[T; N], dead_band: T) -> [T; N] {
        if !self.scrubs {
            return [T::ZERO; N];
        }
        let turning = dot(&self.turn, wheel_speed);
        let sign = if turning.abs() > dead_band { turning.sign() } else { T::ZERO };
        self.turn.map(|share| share * sign)
    }

    /// The rows, m².
    pub fn rows(&self) -> &[[T; N]; N] {
        &self.rows
    }
}

#[inline]
fn dot<T: Real, const N: usize>(one: &[T; N], other: &[T; N]) -> T {
    let mut sum = T::NOTHING;
    for (a, b) in one.iter().zip(other) {
        sum += *a * *b;
    }
    sum
}

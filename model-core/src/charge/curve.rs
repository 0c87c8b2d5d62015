//! Open-circuit voltage of a cell over its charge: a table, straight in between.

use crate::real::Real;

/// Most points that a curve has.
pub const MOST_POINTS: usize = 24;

/// A point of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point<T> {
    /// Charge as a share of the capacity, 0 to 1.
    pub charge: T,
    /// Voltage of a cell at rest, V.
    pub voltage: T,
}

/// Open-circuit voltage over charge, from 0 to 1, rising.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curve<T> {
    points: [Point<T>; MOST_POINTS],
    count: usize,
}

/// Of a cell Molicel INR-21700-P42A (NCA, graphite): discharged and charged at C/32 and room
/// temperature, the mean of both. From S. Sunil, K. R. Pattipati, B. Balasingam, "Piecewise Linear
/// Approximation of Battery Open-Circuit Voltage Characteristics Using Dynamic Programming", IEEE
/// Transactions on Instrumentation and Measurement, 2025; the points that they chose. For packs
/// whose own curve is not known: cells of this chemistry differ from it by some 10 mV between a
/// tenth and full.
const LITHIUM_ION: [(f64, f64); 10] = [
    (0.0, 2.5061),
    (0.0151, 2.8981),
    (0.0452, 3.1461),
    (0.0955, 3.3231),
    (0.1508, 3.4218),
    (0.2915, 3.5737),
    (0.4573, 3.7017),
    (0.8342, 4.0637),
    (0.9497, 4.1009),
    (1.0, 4.1932),
];

/// A straight piece between two points.
#[derive(Clone, Copy)]
struct Piece<T> {
    from: Point<T>,
    to: Point<T>,
}

impl<T: Real> Piece<T> {
    /// V per unit of charge.
    fn slope(&self) -> T {
        (self.to.voltage - self.from.voltage) / (self.to.charge - self.from.charge)
    }

    fn at(&self, charge: T) -> T {
        self.from.voltage + self.slope() * (charge - self.from.charge)
    }
}

impl<T: Real> Curve<T> {
    /// Of a lithium-ion cell where nothing else is known.
    pub fn lithium_ion() -> Self {
        let mut curve = Self { points: [Point::default(); MOST_POINTS], count: LITHIUM_ION.len() };
        for (point, (charge, voltage)) in curve.points.iter_mut().zip(LITHIUM_ION) {
            *point = Point { charge: T::from_f64(charge), voltage: T::from_f64(voltage) };
        }
        curve
    }

    /// Through these points. `None` unless they are 2 to [`MOST_POINTS`], charges rise from 0 to 1,
    /// and voltages are above 0 and rise.
    pub fn new(points: impl IntoIterator<Item = Point<T>>) -> Option<Self> {
        let mut curve = Self { points: [Point::default(); MOST_POINTS], count: 0 };
        let mut last: Option<Point<T>> = None;
        for point in points {
            let rises = match last {
                None => point.charge == T::ZERO && point.voltage > T::ZERO,
                Some(last) => point.charge > last.charge && point.voltage > last.voltage,
            };
            if !(rises && point.charge <= T::ONE && point.voltage.is_finite()) {
                return None;
            }
            *curve.points.get_mut(curve.count)? = point;
            curve.count += 1;
            last = Some(point);
        }
        (curve.count > 1 && last?.charge == T::ONE).then_some(curve)
    }

    /// The points.
    pub fn points(&self) -> &[Point<T>] {
        self.points.get(..self.count).unwrap_or(&self.points)
    }

    fn pieces(&self) -> impl Iterator<Item = Piece<T>> + '_ {
        let points = self.points();
        points.iter().zip(points.iter().skip(1)).map(|(from, to)| Piece { from: *from, to: *to })
    }

    /// The first piece whose end `is_behind` accepts, or the last one.
    fn piece(&self, is_behind: impl Fn(&Point<T>) -> bool) -> Piece<T> {
        let mut chosen = Piece { from: Point::default(), to: Point { charge: T::ONE, voltage: T::ONE } };
        for piece in self.pieces() {
            chosen = piece;
            if is_behind(&piece.to) {
                break;
            }
        }
        chosen
    }

    /// Voltage at rest, V, at a charge; beyond 0 and 1 the outermost pieces go on.
    pub fn voltage(&self, charge: T) -> T {
        self.piece(|end| end.charge >= charge).at(charge)
    }

    /// The charge at which the voltage at rest is this, 0 to 1.
    pub fn charge(&self, voltage: T) -> T {
        let piece = self.piece(|end| end.voltage >= voltage);
        let charge = piece.from.charge + (voltage - piece.from.voltage) / piece.slope();
        T::ZERO.at_least(charge).at_most(T::ONE)
    }

    /// ∫ V dq from one charge to a higher one, V: what a cell gives per ampere-second of capacity
    /// without losses.
    pub fn energy(&self, from: T, to: T) -> T {
        let mut sum = T::ZERO;
        for piece in self.pieces() {
            let (low, high) = (piece.from.charge.at_least(from), piece.to.charge.at_most(to));
            if high > low {
                sum += (high - low) * (piece.at(low) + piece.at(high)) * T::HALF;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use std::vec;

    use super::*;

    fn point(charge: f64, voltage: f64) -> Point<f64> {
        Point { charge, voltage }
    }

    /// By hand on two pieces: 3 V at 0, 3.5 V at ½, 4.5 V at 1; ∫ from ¼ to ¾ is ¼ · 3.375 + ¼ ·
    /// 3.75.
    #[test]
    fn straight_between_its_points() {
        let curve = Curve::new([point(0.0, 3.0), point(0.5, 3.5), point(1.0, 4.5)]).unwrap();
        for (charge, voltage) in [(0.0, 3.0), (0.25, 3.25), (0.5, 3.5), (0.75, 4.0), (1.0, 4.5)] {
            assert!((curve.voltage(charge) - voltage).abs() < 1e-12);
            assert!((curve.charge(voltage) - charge).abs() < 1e-12);
        }
        assert_eq!((curve.charge(2.0), curve.charge(9.0)), (0.0, 1.0));
        assert!((curve.energy(0.25, 0.75) - 0.25 * (3.375 + 3.75)).abs() < 1e-12);
        assert_eq!(curve.energy(0.5, 0.5), 0.0);
    }

    #[test]
    fn what_is_no_curve_is_none() {
        let many = (0..=MOST_POINTS).map(|i| point(i as f64 / MOST_POINTS as f64, 3.0 + i as f64));
        assert!(Curve::new(many).is_none());
        for points in [
            vec![],
            vec![point(0.0, 3.0)],
            vec![point(0.1, 3.0), point(1.0, 4.0)],
            vec![point(0.0, 3.0), point(0.9, 4.0)],
            vec![point(0.0, 3.0), point(0.5, 3.0), point(1.0, 4.0)],
            vec![point(0.0, 3.0), point(0.5, f64::NAN), point(1.0, 4.0)],
            vec![point(0.0, 3.0), point(1.0, f64::INFINITY)],
        ] {
            assert!(Curve::new(points.clone()).is_none(), "{points:?}");
        }
        let lithium = Curve::<f64>::lithium_ion();
        assert_eq!(Curve::new(lithium.points().iter().copied()), Some(lithium));
    }
}

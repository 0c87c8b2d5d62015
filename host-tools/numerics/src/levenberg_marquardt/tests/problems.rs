//! Residuals, starts and minima of the test problems, numbered as in the paper.

use std::f64::consts::PI;

/// One problem.
pub(super) struct Problem {
    pub name: &'static str,
    pub residuals: fn(&[f64]) -> Vec<f64>,
    pub start: &'static [f64],
    /// Sums of squares at its minima.
    pub minima: &'static [f64],
    /// Whether ten times the start leads there too.
    pub far: bool,
}

const fn problem(
    name: &'static str,
    residuals: fn(&[f64]) -> Vec<f64>,
    start: &'static [f64],
    minima: &'static [f64],
    far: bool,
) -> Problem {
    Problem { name, residuals, start, minima, far }
}

pub(super) const PROBLEMS: &[Problem] = &[
    problem("1 Rosenbrock", rosenbrock, &[-1.2, 1.0], &[0.0], true),
    problem("2 Freudenstein and Roth", freudenstein_roth, &[0.5, -2.0], &[0.0, 48.9842], true),
    problem("3 Powell, badly scaled", powell_badly_scaled, &[0.0, 1.0], &[0.0], false),
    problem("4 Brown, badly scaled", brown_badly_scaled, &[1.0, 1.0], &[0.0], false),
    problem("5 Beale", beale, &[1.0, 1.0], &[0.0], false),
    problem("6 Jennrich and Sampson", jennrich_sampson, &[0.3, 0.4], &[124.362], false),
    problem("7 helical valley", helical_valley, &[-1.0, 0.0, 0.0], &[0.0], true),
    problem("8 Bard", bard, &[1.0, 1.0, 1.0], &[8.21487e-3], false),
    problem("9 Gaussian", gaussian, &[0.4, 1.0, 0.0], &[1.12793e-8], false),
    problem("10 Meyer", meyer, &[0.02, 4000.0, 250.0], &[87.9458], false),
    problem("12 Box, three-dimensional", box_3d, &[0.0, 10.0, 20.0], &[0.0], false),
    problem("13 Powell, singular", powell_singular, &[3.0, -1.0, 0.0, 1.0], &[0.0], true),
    problem("14 Wood", wood, &[-3.0, -1.0, -3.0, -1.0], &[0.0], true),
    problem(
        "15 Kowalik and Osborne",
        kowalik_osborne,
        &[0.25, 0.39, 0.415, 0.39],
        &[3.07505e-4, 1.02734e-3],
        false,
    ),
    problem("16 Brown and Dennis", brown_dennis, &[25.0, 5.0, -5.0, -1.0], &[85822.2], true),
    problem("17 Osborne 1", osborne_1, &[0.5, 1.5, -1.0, 0.01, 0.02], &[5.46489e-5], false),
    problem("18 Biggs EXP6", biggs, &[1.0, 2.0, 1.0, 1.0, 1.0, 1.0], &[0.0, 5.65565e-3], false),
    problem(
        "19 Osborne 2",
        osborne_2,
        &[1.3, 0.65, 0.65, 0.7, 0.6, 3.0, 5.0, 7.0, 2.0, 4.5, 5.5],
        &[4.01377e-2],
        false,
    ),
    problem("20 Watson, n = 6", watson, &[0.0; 6], &[2.28767e-3], false),
    problem("20 Watson, n = 9", watson, &[0.0; 9], &[1.39976e-6], false),
    // Σ r² = m − n.
    problem("32 linear, full rank", linear_full_rank, &[1.0; 5], &[5.0], true),
    // m (m − 1) / (2 (2 m + 1)).
    problem("33 linear, rank 1", linear_rank_1, &[1.0; 5], &[10.0 * 9.0 / 42.0], true),
];

fn rosenbrock(x: &[f64]) -> Vec<f64> {
    vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]
}

fn freudenstein_roth(x: &[f64]) -> Vec<f64> {
    vec![
        -13.0 + x[0] + ((5.0 - x[1]) * x[1] - 2.0) * x[1],
        -29.0 + x[0] + ((x[1] + 1.0) * x[1] - 14.0) * x[1],
    ]
}

fn powell_badly_scaled(x: &[f64]) -> Vec<f64> {
    vec![1e4 * x[0] * x[1] - 1.0, (-x[0]).exp() + (-x[1]).exp() - 1.0001]
}

fn brown_badly_scaled(x: &[f64]) -> Vec<f64> {
    vec![x[0] - 1e6, x[1] - 2e-6, x[0] * x[1] - 2.0]
}

fn beale(x: &[f64]) -> Vec<f64> {
    [(1.5, 1), (2.25, 2), (2.625, 3)].map(|(y, power)| y - x[0] * (1.0 - x[1].powi(power))).to_vec()
}

fn jennrich_sampson(x: &[f64]) -> Vec<f64> {
    let one = |i: f64| 2.0 + 2.0 * i - ((i * x[0]).exp() + (i * x[1]).exp());
    (1..=10).map(|i| one(f64::from(i))).collect()
}

fn helical_valley(x: &[f64]) -> Vec<f64> {
    let turn = (x[1] / x[0]).atan() / (2.0 * PI) + if x[0] < 0.0 { 0.5 } else { 0.0 };
    vec![10.0 * (x[2] - 10.0 * turn), 10.0 * (x[0].hypot(x[1]) - 1.0), x[2]]
}

fn bard(x: &[f64]) -> Vec<f64> {
    const Y: [f64; 15] =
        [0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39];
    let one = |(i, y): (usize, f64)| {
        let u = i as f64 + 1.0;
        let v = 16.0 - u;
        y - (x[0] + u / (v * x[1] + u.min(v) * x[2]))
    };
    Y.into_iter().enumerate().map(one).collect()
}

fn gaussian(x: &[f64]) -> Vec<f64> {
    const HALF: [f64; 8] = [0.0009, 0.0044, 0.0175, 0.0540, 0.1295, 0.2420, 0.3521, 0.3989];
    let one = |i: usize| {
        let t = (8.0 - (i as f64 + 1.0)) / 2.0;
        x[0] * (-x[1] * (t - x[2]).powi(2) / 2.0).exp() - HALF[i.min(14 - i)]
    };
    (0..15).map(one).collect()
}

fn meyer(x: &[f64]) -> Vec<f64> {
    const Y: [f64; 16] = [
        34780.0, 28610.0, 23650.0, 19630.0, 16370.0, 13720.0, 11540.0, 9744.0, 8261.0, 7030.0, 6005.0,
        5147.0, 4427.0, 3820.0, 3307.0, 2872.0,
    ];
    let one = |(i, y): (usize, f64)| x[0] * (x[1] / (45.0 + 5.0 * (i as f64 + 1.0) + x[2])).exp() - y;
    Y.into_iter().enumerate().map(one).collect()
}

fn box_3d(x: &[f64]) -> Vec<f64> {
    let one = |i: i32| {
        let t = 0.1 * f64::from(i);
        (-t * x[0]).exp() - (-t * x[1]).exp() - x[2] * ((-t).exp() - (-10.0 * t).exp())
    };
    (1..=10).map(one).collect()
}

fn powell_singular(x: &[f64]) -> Vec<f64> {
    vec![
        x[0] + 10.0 * x[1],
        5.0_f64.sqrt() * (x[2] - x[3]),
        (x[1] - 2.0 * x[2]).powi(2),
        10.0_f64.sqrt() * (x[0] - x[3]).powi(2),
    ]
}

fn wood(x: &[f64]) -> Vec<f64> {
    vec![
        10.0 * (x[1] - x[0] * x[0]),
        1.0 - x[0],
        90.0_f64.sqrt() * (x[3] - x[2] * x[2]),
        1.0 - x[2],
        10.0_f64.sqrt() * (x[1] + x[3] - 2.0),
        (x[1] - x[3]) / 10.0_f64.sqrt(),
    ]
}

fn kowalik_osborne(x: &[f64]) -> Vec<f64> {
    const ROWS: [(f64, f64); 11] = [
        (0.1957, 4.0),
        (0.1947, 2.0),
        (0.1735, 1.0),
        (0.1600, 0.5),
        (0.0844, 0.25),
        (0.0627, 0.167),
        (0.0456, 0.125),
        (0.0342, 0.1),
        (0.0323, 0.0833),
        (0.0235, 0.0714),
        (0.0246, 0.0625),
    ];
    ROWS.map(|(y, u)| y - x[0] * (u * u + u * x[1]) / (u * u + u * x[2] + x[3])).to_vec()
}

fn brown_dennis(x: &[f64]) -> Vec<f64> {
    let one = |i: i32| {
        let t = f64::from(i) / 5.0;
        (x[0] + t * x[1] - t.exp()).powi(2) + (x[2] + x[3] * t.sin() - t.cos()).powi(2)
    };
    (1..=20).map(one).collect()
}

fn osborne_1(x: &[f64]) -> Vec<f64> {
    const Y: [f64; 33] = [
        0.844, 0.908, 0.932, 0.936, 0.925, 0.908, 0.881, 0.850, 0.818, 0.784, 0.751, 0.718, 0.685, 0.658,
        0.628, 0.603, 0.580, 0.558, 0.538, 0.522, 0.506, 0.490, 0.478, 0.467, 0.457, 0.448, 0.438, 0.431,
        0.424, 0.420, 0.414, 0.411, 0.406,
    ];
    let one = |(i, y): (usize, f64)| {
        let t = 10.0 * i as f64;
        y - (x[0] + x[1] * (-t * x[3]).exp() + x[2] * (-t * x[4]).exp())
    };
    Y.into_iter().enumerate().map(one).collect()
}

fn biggs(x: &[f64]) -> Vec<f64> {
    let one = |i: i32| {
        let t = 0.1 * f64::from(i);
        let y = (-t).exp() - 5.0 * (-10.0 * t).exp() + 3.0 * (-4.0 * t).exp();
        x[2] * (-t * x[0]).exp() - x[3] * (-t * x[1]).exp() + x[5] * (-t * x[4]).exp() - y
    };
    (1..=13).map(one).collect()
}

fn osborne_2(x: &[f64]) -> Vec<f64> {
    const Y: [f64; 65] = [
        1.366, 1.191, 1.112, 1.013, 0.991, 0.885, 0.831, 0.847, 0.786, 0.725, 0.746, 0.679, 0.608, 0.655,
        0.616, 0.606, 0.602, 0.626, 0.651, 0.724, 0.649, 0.649, 0.694, 0.644, 0.624, 0.661, 0.612, 0.558,
        0.533, 0.495, 0.500, 0.423, 0.395, 0.375, 0.372, 0.391, 0.396, 0.405, 0.428, 0.429, 0.523, 0.562,
        0.607, 0.653, 0.672, 0.708, 0.633, 0.668, 0.645, 0.632, 0.591, 0.559, 0.597, 0.625, 0.739, 0.710,
        0.729, 0.720, 0.636, 0.581, 0.428, 0.292, 0.162, 0.098, 0.054,
    ];
    let one = |(i, y): (usize, f64)| {
        let t = i as f64 / 10.0;
        let peak = |height: f64, width: f64, at: f64| height * (-(t - at).powi(2) * width).exp();
        y - (x[0] * (-t * x[4]).exp()
            + peak(x[1], x[5], x[8])
            + peak(x[2], x[6], x[9])
            + peak(x[3], x[7], x[10]))
    };
    Y.into_iter().enumerate().map(one).collect()
}

fn watson(x: &[f64]) -> Vec<f64> {
    let one = |i: i32| {
        let t = f64::from(i) / 29.0;
        let slope: f64 = (1..).zip(&x[1..]).map(|(j, x)| f64::from(j) * x * t.powi(j - 1)).sum();
        let value: f64 = (0..).zip(x).map(|(j, x)| x * t.powi(j)).sum();
        slope - value * value - 1.0
    };
    (1..=29).map(one).chain([x[0], x[1] - x[0] * x[0] - 1.0]).collect()
}

/// Rows of the linear problems.
const ROWS: usize = 10;

fn linear_full_rank(x: &[f64]) -> Vec<f64> {
    let shift = 2.0 / ROWS as f64 * x.iter().sum::<f64>() + 1.0;
    (0..ROWS).map(|i| x.get(i).copied().unwrap_or(0.0) - shift).collect()
}

fn linear_rank_1(x: &[f64]) -> Vec<f64> {
    let sum: f64 = (1..).zip(x).map(|(j, x)| f64::from(j) * x).sum();
    (1..=ROWS).map(|i| i as f64 * sum - 1.0).collect()
}

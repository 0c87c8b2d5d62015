//! Wide lines in bitmaps.

use plotters_backend::{BackendColor, BackendCoord, BackendStyle, DrawingBackend, DrawingErrorKind};

/// A backend of pixels whose wide lines have no needles.
///
/// plotters makes a polygon of a wide line, and a corner of it at the crossing of the two edges. On
/// the inner side of a sharp turn these cross far away, up to hundreds of pixels: a needle, or a
/// hole where it folds over the line. So a line is drawn in pieces, which end where it turns by
/// more than a right angle; up to there a corner is at most 1.5 half widths away.
pub(super) struct Raster<B>(pub(super) B);

type Outcome<B> = Result<(), DrawingErrorKind<<B as DrawingBackend>::ErrorType>>;

impl<B: DrawingBackend> DrawingBackend for Raster<B> {
    type ErrorType = B::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.0.get_size()
    }

    fn ensure_prepared(&mut self) -> Outcome<B> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> Outcome<B> {
        self.0.present()
    }

    fn draw_pixel(&mut self, point: BackendCoord, colour: BackendColor) -> Outcome<B> {
        self.0.draw_pixel(point, colour)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Outcome<B> {
        self.0.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        lower_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Outcome<B> {
        self.0.draw_rect(upper_left, lower_right, style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Outcome<B> {
        let path: Vec<BackendCoord> = path.into_iter().collect();
        if style.stroke_width() < 2 {
            return self.0.draw_path(path, style);
        }
        pieces(&path).into_iter().try_for_each(|piece| self.0.draw_path(piece, style))
    }
}

/// A line in pieces without sharp turns.
fn pieces(path: &[BackendCoord]) -> Vec<Vec<BackendCoord>> {
    let mut path = path.to_vec();
    path.dedup();
    let mut pieces = Vec::new();
    let mut piece: Vec<BackendCoord> = Vec::new();
    for &next in &path {
        if let [.., before, last] = piece[..] {
            let along =
                |from: BackendCoord, to: BackendCoord| (i64::from(to.0 - from.0), i64::from(to.1 - from.1));
            let ((ax, ay), (bx, by)) = (along(before, last), along(last, next));
            if ax * bx + ay * by < 0 {
                pieces.push(std::mem::replace(&mut piece, vec![last]));
            }
        }
        piece.push(next);
    }
    if piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::{Raster, pieces};
    use plotters::prelude::*;

    #[test]
    fn a_line_ends_at_sharp_turns_only() {
        assert_eq!(pieces(&[(0, 0), (1, 50), (2, 0)]), [[(0, 0), (1, 50)], [(1, 50), (2, 0)]]);
        assert_eq!(pieces(&[(0, 0), (5, 0), (5, 5), (9, 7)]).len(), 1);
        assert!(pieces(&[(3, 3), (3, 3)]).is_empty());
    }

    /// A peak 2 pixels wide and 60 high, 4 pixels thick: nothing of it is outside of its box,
    /// widened by the thickness. (Without the pieces the corner on the inner side is at 4 ∕ 2 ∕
    /// sin(1 ∕ 60) = 120 pixels below the peak.)
    #[test]
    fn a_sharp_peak_has_no_needle() {
        let size = (100, 200);
        let mut pixels = vec![0; 3 * 100 * 200];
        {
            let root = Raster(BitMapBackend::with_buffer(&mut pixels, size)).into_drawing_area();
            root.fill(&WHITE).unwrap();
            root.draw(&PathElement::new(vec![(49, 100), (50, 40), (51, 100)], BLACK.stroke_width(4)))
                .unwrap();
            root.present().unwrap();
        }
        let dark = |x: usize, y: usize| pixels[3 * (100 * y + x)] < 128;
        for (x, y) in (0..200).flat_map(|y| (0..100).map(move |x| (x, y))) {
            let inside = (45..=55).contains(&x) && (36..=104).contains(&y);
            assert!(inside || !dark(x, y), "{x} {y}");
        }
        assert!((45..100).all(|y| dark(50, y)), "the peak itself is there");
    }
}

//! A plot in the page: drawn by plotters, titled and described for those who do not see it.

use maud::{Markup, PreEscaped, html};

use crate::error::Result;
use crate::report::{Page, Panel};

/// Width and height of a plot that takes the whole page.
pub(super) const WHOLE: (u32, u32) = (1000, 340);

/// Of one that shares the page with another.
pub(super) const HALF: (u32, u32) = (560, 330);

/// One plot. `about` says what it shows, and what one sees there.
pub(super) fn figure(
    panel: impl Into<Panel>,
    (width, height): (u32, u32),
    title: &str,
    about: &str,
) -> Result<Markup> {
    let drawn = Page::new([panel.into()]).with_panels_of(width, height).inline()?;
    let view = format!("0 0 {} {}", drawn.size.0, drawn.size.1);
    Ok(html! {
        figure {
            svg viewBox=(view) role="img" aria-label=(format!("{title}. {about}")) {
                title { (title) }
                (PreEscaped(drawn.content))
            }
            figcaption { (about) }
        }
    })
}

//! What the pages of text share: the document around them, plots inside them, tiles.
//!
//! A page is self-contained (no network, plots inline; scripts only where plots are zoomed) and
//! well-formed XML, too, so that a test can read it strictly. Every text goes through maud, which
//! escapes it.

use maud::{Markup, PreEscaped, html};
use support::error::Result;
use support::printable;

use super::heat::NUMBER_SIZE;
use super::{Page, Panel};

/// Width and height of a plot that takes the whole page.
pub const WHOLE: (u32, u32) = (1000, 340);

/// Of one of two plots side by side.
pub const HALF: (u32, u32) = (520, 330);

/// One plot. `about` says what it shows, and what one sees there.
pub fn figure(
    panel: impl Into<Panel>,
    (width, height): (u32, u32),
    title: &str,
    about: &str,
) -> Result<Markup> {
    drawing(&Page::new([panel.into()]).with_panels_of(width, height), title, about, None)
}

/// A stack of plots, drawn by plotters, titled and described for those who do not see it; `numbers`
/// is what a script makes more of.
pub fn drawing(page: &Page, title: &str, about: &str, numbers: Option<Markup>) -> Result<Markup> {
    let drawn = page.inline()?;
    let view = format!("0 0 {} {}", drawn.size.0, drawn.size.1);
    Ok(html! {
        figure {
            svg viewBox=(view) style=(format!("min-width:{:.0}px", least_width(drawn.size.0))) role="img" aria-label=(format!("{title}. {about}")) {
                title { (title) }
                (PreEscaped(drawn.content))
            }
            figcaption { (about) }
            @if let Some(numbers) = numbers { (numbers) }
        }
    })
}

/// Text in plots is at least so tall on any screen, px: smaller letters are not read on a phone.
const LEAST_TEXT_PX: f64 = 11.0;

/// The SVG backend of plotters writes letters smaller than it is asked for, by this factor.
const LINE_PER_TEXT: f64 = 1.24;

/// The least width of a drawing so many units wide, px; a narrower screen scrolls it.
#[must_use]
pub fn least_width(units: u32) -> f64 {
    f64::from(units) * LEAST_TEXT_PX * LINE_PER_TEXT / f64::from(NUMBER_SIZE)
}

/// A figure in large letters, and what it is.
pub fn tile(figure: &str, what: &str, class: &str) -> Markup {
    html! { div class="tile" { b class=(class) { (figure) } span { (what) } } }
}

/// Void elements are closed as in XML, which HTML allows.
const HEAD: &str = "<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
                    <meta name=\"color-scheme\" content=\"light dark\"/>";

/// The page around `body`.
pub fn document(title: &str, body: Markup) -> String {
    page(title, "", body)
}

/// The same, with more style.
pub(super) fn page(title: &str, more_style: &str, body: Markup) -> String {
    let page = html! {
        (PreEscaped("<!DOCTYPE html>\n"))
        html lang="en" {
            head {
                (PreEscaped(HEAD))
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) (PreEscaped(more_style)) }
            }
            body { main { (body) } }
        }
    };
    // maud escapes what acts in HTML. Names come from files, and what acts on a terminal is no XML
    // either.
    printable::text(&page.into_string()).into_owned()
}

//! Text for terminals: names come from files and boards, and what they hold must not move the
//! cursor, set the title or forge a line.
//!
//! Control characters, line and paragraph separators and those that turn the direction of writing
//! are shown as JSON does, `\u001b`, so that JSON stays JSON.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Characters of a line on standard error, at most: a dozen lines of a terminal.
pub const LONGEST_LINE: usize = 1000;

/// Of these the last ones: what was expected, and the remedy, stand at the end.
const LONGEST_END: usize = 400;

pub fn is_harmful(character: char) -> bool {
    let separates = matches!(character, '\u{2028}' | '\u{2029}');
    let turns = matches!(character, '\u{200e}' | '\u{200f}' | '\u{061c}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    (character.is_control() && character != '\n') || separates || turns
}

/// The text with harmful characters shown; line feeds stay.
pub fn text(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_harmful) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if is_harmful(character) {
            // Writing to a String cannot fail.
            let _ = write!(shown, "\\u{:04x}", u32::from(character));
        } else {
            shown.push(character);
        }
    }
    shown.into()
}

/// The same on one line: for names within it.
pub fn name(name: &str) -> String {
    text(name).replace('\n', "\\u000a")
}

/// The same, cut to [`LONGEST_LINE`] in its middle: a line of its own.
pub fn line(line: &str) -> String {
    let shown = name(line);
    let count = shown.chars().count();
    if count <= LONGEST_LINE {
        return shown;
    }
    let start = shown.chars().take(LONGEST_LINE - LONGEST_END - 1);
    start.chain(std::iter::once('…')).chain(shown.chars().skip(count - LONGEST_END)).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::{any, prop_assert, proptest};

    use super::*;

    #[test]
    fn what_would_act_on_a_terminal_is_shown() {
        assert_eq!(text("\u{1b}]0;title\u{7}\r\tµ … é"), "\\u001b]0;title\\u0007\\u000d\\u0009µ … é");
        assert_eq!(text("a\n\u{9b}2J\u{202e}b\u{2028}"), "a\n\\u009b2J\\u202eb\\u2028");
        assert_eq!(name("a\ngmr: forged"), "a\\u000agmr: forged");
        let json = serde_json::to_string("\u{9b}2J\u{7f}").unwrap();
        assert_eq!(serde_json::from_str::<String>(&text(&json)).unwrap(), "\u{9b}2J\u{7f}");
    }

    #[test]
    fn a_line_is_one_line_and_ends() {
        let shown = line(&format!("{}; expected less", "é\n".repeat(3 * LONGEST_LINE)));
        assert_eq!((shown.chars().count(), shown.lines().count()), (LONGEST_LINE, 1));
        assert!(shown.starts_with("é\\u000aé") && shown.contains('…') && shown.ends_with("; expected less"));
        assert_eq!(line("short"), "short");
    }

    proptest! {
        #[test]
        fn nothing_harmful_is_left(wild in any::<String>()) {
            prop_assert!(!text(&wild).chars().any(is_harmful));
            prop_assert!(!line(&wild).contains('\n'));
        }
    }
}

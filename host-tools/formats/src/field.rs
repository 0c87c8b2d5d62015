//! A number within a message: `/joint_states:velocity[wheel_left_joint]`,
//! `/odom:twist.twist.linear.x`, `esc_status:esc[0].esc_rpm`.

use crate::error::{Error, Result};

/// One step into a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Step {
    /// A member.
    Member(String),
    /// An element of an array.
    Index(usize),
    /// The element of an array that stands where this name stands in the `name` array before it.
    Named(String),
}

/// A topic and a path into its messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// The topic's name.
    pub topic: String,
    /// The path, as written.
    pub path: String,
    pub(crate) steps: Vec<Step>,
}

impl Field {
    /// Of a topic and a path.
    ///
    /// # Errors
    /// A path that is none.
    pub fn new(topic: &str, path: &str) -> Result<Self> {
        let steps = steps(path).ok_or_else(|| {
            Error::Choice(format!(
                "{path:?} is no field; expected such as twist.twist.linear.x or velocity[0]"
            ))
        })?;
        Ok(Self { topic: topic.to_owned(), path: path.to_owned(), steps })
    }

    /// Whether it is of an element of an array by its name.
    pub(crate) fn is_named(&self) -> bool {
        self.steps.iter().any(|step| matches!(step, Step::Named(_)))
    }

    /// Of `topic:path`.
    ///
    /// # Errors
    /// No colon, or a path that is none.
    pub fn parse(text: &str) -> Result<Self> {
        let Some((topic, path)) = text.split_once(':').filter(|(topic, _)| !topic.is_empty()) else {
            let message =
                format!("{text:?} is no field of a topic; expected topic:field, such as /power:data");
            return Err(Error::Choice(message));
        };
        Self::new(topic, path)
    }
}

impl std::fmt::Display for Field {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.topic, self.path)
    }
}

fn steps(path: &str) -> Option<Vec<Step>> {
    let mut steps = Vec::new();
    let mut rest = path;
    while !rest.is_empty() {
        if let Some(index) = rest.strip_prefix('[') {
            let (index, after) = index.split_once(']')?;
            steps.push(match index.parse() {
                Ok(number) => Step::Index(number),
                Err(_) if index.is_empty() => return None,
                Err(_) => Step::Named(index.to_owned()),
            });
            rest = after;
        } else {
            let member = rest.strip_prefix('.').unwrap_or(rest);
            let end = member.find(['.', '[']).unwrap_or(member.len());
            if end == 0 {
                return None;
            }
            steps.push(Step::Member(member[..end].to_owned()));
            rest = &member[end..];
        }
    }
    (!steps.is_empty()).then_some(steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_members_indices_and_names() {
        let field = Field::parse("/js:velocity[wheel_left_joint]").unwrap();
        assert_eq!(field.topic, "/js");
        let member = |name: &str| Step::Member(name.to_owned());
        assert_eq!(field.steps, [member("velocity"), Step::Named("wheel_left_joint".to_owned())]);
        let deep = Field::parse("esc_status:esc[2].rpm").unwrap();
        assert_eq!(deep.steps, [member("esc"), Step::Index(2), member("rpm")]);
        for wrong in ["", "/js", ":x", "/js:", "/js:a..b", "/js:a[", "/js:a[]"] {
            assert!(Field::parse(wrong).is_err(), "{wrong}");
        }
    }
}

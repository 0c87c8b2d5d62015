//! What a bucket refuses, in a line that says what would mend it.

use object_store::Error as Refused;
use support::error::Error;

/// Where clouds keep what their machines may do. Who asks there has found no credentials elsewhere.
const METADATA: [&str; 4] =
    ["/latest/api/token", "/latest/meta-data", "/computeMetadata/", "/metadata/identity"];

const CREDENTIALS: &str = "expected AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, GOOGLE_SERVICE_ACCOUNT or AZURE_STORAGE_ACCOUNT_NAME and \
                           AZURE_STORAGE_ACCOUNT_KEY in the environment, or, of a public bucket, AWS_SKIP_SIGNATURE=true (GOOGLE_, AZURE_)";

/// A bucket that cannot be listed.
pub(super) fn list(error: &Refused) -> Error {
    let said = why(error);
    // A listing's 404 comes as an error of no kind.
    if matches!(error, Refused::NotFound { .. }) || said.contains("404 Not Found") {
        return Error::failed(format!("no such bucket, or none that may be listed: {said}"));
    }
    object(error)
}

/// An object that cannot be had.
pub(super) fn object(error: &Refused) -> Error {
    let said = why(error);
    if METADATA.iter().any(|path| said.contains(path)) {
        return Error::failed(format!("no credentials; {CREDENTIALS}"));
    }
    // What reqwest says of a scheme that it was not allowed.
    if said.contains("builder error") {
        return Error::failed(format!("{said}; expected an endpoint of https, or AWS_ALLOW_HTTP=true"));
    }
    Error::failed(match error {
        Refused::PermissionDenied { .. } | Refused::Unauthenticated { .. } => {
            format!("the bucket refuses access: {said}; {CREDENTIALS}")
        }
        Refused::NotFound { .. } => format!("is not in the bucket any more: {said}"),
        Refused::Precondition { .. } => "has been written again since it was listed".to_owned(),
        _ => said,
    })
}

/// The reason below, without the words and the XML that a server puts around it.
fn why(error: &Refused) -> String {
    let text = match error {
        Refused::Generic { source, .. }
        | Refused::NotFound { source, .. }
        | Refused::PermissionDenied { source, .. }
        | Refused::Unauthenticated { source, .. } => source.to_string(),
        _ => error.to_string(),
    };
    let text = text.split('<').next().unwrap_or_default().trim_end_matches([':', ' ']);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

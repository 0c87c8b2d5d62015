//! Futures without an executor.

use core::future::Future;
use core::pin::pin;
use core::task::Poll;

use embassy_futures::poll_once;

use crate::{Failed, ensure};

/// What a future gives that never waits, as those do whose buses are mocks.
///
/// # Errors
/// [`Failed`], reported with the caller's place, when it waits.
#[track_caller]
pub fn now<T>(future: impl Future<Output = T>) -> Result<T, Failed> {
    match poll_once(pin!(future)) {
        Poll::Ready(value) => Ok(value),
        Poll::Pending => {
            ensure(false, format_args!("it waits for what never comes"))?;
            Err(Failed)
        }
    }
}

//! What tests share.

use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

/// Mocks answer at once, so a future that is not ready is a bug.
pub(crate) fn now<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => value,
        Poll::Pending => panic!("a mock never waits"),
    }
}

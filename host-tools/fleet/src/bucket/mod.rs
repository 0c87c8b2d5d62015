//! A bucket as the source of a fleet's logs: listed, and its objects copied here whole, some of
//! them ahead of who reads them.
//!
//! `object_store` talks to the bucket; what it is asked for is in [`store`], what it says when it
//! refuses in [`refused`].

mod fetch;
mod refused;
mod store;

use std::path::Path;
use std::sync::{Arc, mpsc};

use futures_util::TryStreamExt as _;
use object_store::{ObjectMeta, ObjectStore};
use rayon::prelude::*;
use support::error::{Error, Result};
use tokio::runtime::Runtime;

use self::fetch::{Fetched, Wanted, fetch_all};
use super::logs::{Log, Place};

/// A bucket, or what is below a path in it.
#[derive(Debug)]
pub(crate) struct Bucket {
    url: String,
    store: Arc<dyn ObjectStore>,
    prefix: object_store::path::Path,
    runtime: Runtime,
}

/// Ends the fetching when its receiver is gone.
struct Ended(tokio::task::AbortHandle);

impl Drop for Ended {
    fn drop(&mut self) {
        self.0.abort();
    }
}

impl Bucket {
    /// Of `s3://bucket/logs`, `gs://…`, `az://…`, `https://…` or `file:///…`, with what the
    /// environment says of credentials and endpoints.
    ///
    /// # Errors
    /// No such kind of URL; an environment that does not fit it.
    pub(super) fn open(url: &str) -> Result<Self> {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .map_err(|error| Error::of_system(&error))?;
        // Stores of a cloud begin work of their own where they are made.
        let _within = runtime.enter();
        let (store, prefix) = store::of(url)?;
        Ok(Self { url: url.to_owned(), store, prefix, runtime })
    }

    /// As it was given.
    pub(super) fn url(&self) -> &str {
        &self.url
    }

    /// All logs in it, in the bucket's order.
    ///
    /// # Errors
    /// It is not there, or does not let itself be listed.
    pub(super) fn find(&self, group: &[String]) -> Result<Vec<Log>> {
        let listed: Vec<ObjectMeta> = self
            .runtime
            .block_on(self.store.list(Some(&self.prefix)).try_collect())
            .map_err(|error| refused::list(&error).in_file(&self.url))?;
        let log = |object: ObjectMeta| {
            let parts: Vec<String> =
                object.location.prefix_match(&self.prefix)?.map(|name| name.as_ref().to_owned()).collect();
            let place = || Place::Object {
                location: object.location.to_string(),
                bytes: object.size,
                version: object.e_tag.unwrap_or_else(|| object.last_modified.to_rfc3339()),
            };
            Log::at(&parts, group, place)
        };
        Ok(listed.into_iter().filter_map(log).collect())
    }

    /// As [`super::Source::each`].
    pub(super) fn each(
        &self,
        logs: &[&Log],
        aside: &Path,
        work: impl Fn(&Log, Result<&Path>) -> Result<()> + Sync,
    ) -> Result<()> {
        // Whoever was killed left theirs.
        let _ = std::fs::remove_dir_all(aside);
        std::fs::create_dir_all(aside).map_err(|error| Error::io(aside, &error))?;
        let wanted = logs.iter().enumerate().filter_map(|(place, log)| Wanted::of(place, log)).collect();
        let (send, receive) = mpsc::channel();
        let store = Arc::clone(&self.store);
        let fetching = self.runtime.spawn(fetch_all(store, wanted, aside.to_owned(), send));
        let _ended = Ended(fetching.abort_handle());
        let done = receive.into_iter().par_bridge().try_for_each(|Fetched { place, file, room }| {
            let done = match &file {
                Ok(file) => work(logs[place], Ok(file.path())),
                Err(refused) => work(logs[place], Err(Error::failed(refused.to_string()))),
            };
            // The next one may come when this one is gone.
            drop(file);
            drop(room);
            done
        });
        let _ = std::fs::remove_dir(aside);
        done
    }
}

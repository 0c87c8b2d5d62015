//! Objects of a bucket into files of this machine.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::Sender;

use futures_util::StreamExt as _;
use object_store::{GetOptions, ObjectStore};
use support::error::{Error, Result};
use support::temporary::{self, Known};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::JoinSet;

use super::refused;
use crate::logs::{Log, Place};

/// Logs that are fetched or here at a time: enough that no core waits for 50 MB/s a stream, few
/// enough for a disk.
const AT_ONCE: usize = 8;

/// An object that is to come.
#[derive(Debug)]
pub(super) struct Wanted {
    /// Which log it is.
    place: usize,
    location: object_store::path::Path,
    bytes: u64,
    version: String,
}

impl Wanted {
    /// The object of a log, where it is one.
    pub(super) fn of(place: usize, log: &Log) -> Option<Self> {
        let Place::Object { location, bytes, version } = &log.place else { return None };
        let location = object_store::path::Path::parse(location).ok()?;
        Some(Self { place, location, bytes: *bytes, version: version.clone() })
    }
}

/// An object that has come, or why it has not.
pub(super) struct Fetched {
    pub(super) place: usize,
    pub(super) file: Result<Copied>,
    /// Held as long as the file is there.
    pub(super) room: OwnedSemaphorePermit,
}

/// An object's copy, which goes with this value.
pub(super) struct Copied {
    file: tempfile::NamedTempFile,
    _known: Known,
}

impl Copied {
    pub(super) fn path(&self) -> &Path {
        self.file.path()
    }
}

/// Fetches them all in their order, [`AT_ONCE`] at a time; dropped, it ends what is on its way.
pub(super) async fn fetch_all(
    store: Arc<dyn ObjectStore>,
    wanted: Vec<Wanted>,
    folder: PathBuf,
    send: Sender<Fetched>,
) {
    let all = Arc::new(Semaphore::new(AT_ONCE));
    let mut running = JoinSet::new();
    for one in wanted {
        let Ok(room) = Arc::clone(&all).acquire_owned().await else { return };
        let (store, folder, send) = (Arc::clone(&store), folder.clone(), send.clone());
        running.spawn(async move {
            let file = fetch(&*store, &one, &folder).await;
            // Nobody takes it where the command has ended.
            let _ = send.send(Fetched { place: one.place, file, room });
        });
        while running.try_join_next().is_some() {}
    }
    while running.join_next().await.is_some() {}
}

async fn fetch(store: &dyn ObjectStore, wanted: &Wanted, folder: &Path) -> Result<Copied> {
    // Only the version that was listed. Weak names (RFC 9110, 13.1.1) and times cannot be asked
    // for.
    let if_match = wanted.version.starts_with('"').then(|| wanted.version.clone());
    let answer = store.get_opts(&wanted.location, GetOptions { if_match, ..GetOptions::default() }).await;
    let mut stream = answer.map_err(|error| refused::object(&error))?.into_stream();
    let local = |error: std::io::Error| Error::io(folder, &error);
    let (mut file, known) = temporary::file_in(folder).map_err(local)?;
    let mut bytes = 0;
    while let Some(block) = stream.next().await {
        let block = block.map_err(|error| refused::object(&error))?;
        file.write_all(&block).map_err(local)?;
        bytes += block.len() as u64;
    }
    if bytes != wanted.bytes {
        return Err(Error::failed(format!("ended after {bytes} of {} bytes", wanted.bytes)));
    }
    Ok(Copied { file, _known: known })
}

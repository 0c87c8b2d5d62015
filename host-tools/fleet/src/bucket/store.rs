//! From a URL to what answers for it.

use std::sync::Arc;
use std::time::Duration;

use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::azure::{AzureConfigKey, MicrosoftAzureBuilder};
use object_store::gcp::{GoogleCloudStorageBuilder, GoogleConfigKey};
use object_store::http::HttpBuilder;
use object_store::local::LocalFileSystem;
use object_store::path::Path;
use object_store::{ClientConfigKey, ObjectStore, ObjectStoreScheme, RetryConfig};
use support::error::{Error, Result};
use url::Url;

use super::refused;

/// How a client waits: an object may take hours, but not half a minute without a byte.
const PATIENCE: [(ClientConfigKey, &str); 2] =
    [(ClientConfigKey::Timeout, "1 day"), (ClientConfigKey::ReadTimeout, "30 seconds")];

/// What is tried again, and how long: what does not come is said, and asked for by the next run.
fn retry() -> RetryConfig {
    RetryConfig { max_retries: 3, retry_timeout: Duration::from_secs(60), ..RetryConfig::default() }
}

/// A store of a cloud, as its variables in the environment have it.
macro_rules! cloud {
    ($builder:ty, $key:path, $url:expr) => {{
        let builder = <$builder>::from_env().with_url($url.as_str()).with_retry(retry());
        let set = |builder: $builder, (key, value)| builder.with_config($key(key), value);
        PATIENCE.into_iter().fold(builder, set).build().map(|store| Arc::new(store) as _)
    }};
}

/// The store, and the path in it.
///
/// # Errors
/// As [`super::Bucket::open`].
pub(super) fn of(url: &str) -> Result<(Arc<dyn ObjectStore>, Path)> {
    // Nobody else in this process speaks TLS; a provider that is there already is as good.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let unknown = |why: String| {
        Error::usage(format!("{why}; expected s3://bucket/path, gs://…, az://…, https://… or file:///…"))
    };
    let parsed = Url::parse(url).map_err(|error| unknown(error.to_string()))?;
    let (scheme, path) = ObjectStoreScheme::parse(&parsed).map_err(|error| unknown(error.to_string()))?;
    let store: object_store::Result<Arc<dyn ObjectStore>> = match scheme {
        ObjectStoreScheme::Local => Ok(Arc::new(LocalFileSystem::new())),
        ObjectStoreScheme::AmazonS3 => cloud!(AmazonS3Builder, AmazonS3ConfigKey::Client, parsed),
        ObjectStoreScheme::GoogleCloudStorage => {
            cloud!(GoogleCloudStorageBuilder, GoogleConfigKey::Client, parsed)
        }
        ObjectStoreScheme::MicrosoftAzure => cloud!(MicrosoftAzureBuilder, AzureConfigKey::Client, parsed),
        ObjectStoreScheme::Http => http(&parsed),
        _ => return Err(unknown("no bucket that can be read".to_owned())),
    };
    Ok((store.map_err(|error| refused::list(&error))?, path))
}

/// A server that lists its folders by WebDAV.
fn http(url: &Url) -> object_store::Result<Arc<dyn ObjectStore>> {
    let root = &url[..url::Position::BeforePath];
    // Whoever writes http:// means it.
    let plain = (ClientConfigKey::AllowHttp, if url.scheme() == "http" { "true" } else { "false" });
    let builder = HttpBuilder::new().with_url(root).with_retry(retry());
    let set = |builder: HttpBuilder, (key, value)| builder.with_config(key, value);
    PATIENCE.into_iter().chain([plain]).fold(builder, set).build().map(|store| Arc::new(store) as _)
}

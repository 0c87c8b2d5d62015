//! Samples as they come, live over Foxglove's WebSocket: with the cargo feature `foxglove` only.
//!
//! The channel, its schema and every message are those of `gmr record --format mcap`. A recording
//! waits for no client: each has a queue that loses its oldest messages where the client is slower
//! than the board.

#[cfg(not(feature = "foxglove"))]
pub use absent::LiveView;
#[cfg(feature = "foxglove")]
pub use serving::LiveView;

/// Foxglove's default address: on this machine only.
pub const ADDRESS: &str = "127.0.0.1:8765";

#[cfg(feature = "foxglove")]
mod serving {
    use std::sync::Arc;

    use foxglove::{ChannelBuilder, Context, PartialMetadata, RawChannel, Schema, WebSocketServerHandle};
    use log_formats::json_rows::{ENCODING, JsonRows, SCHEMA, SCHEMA_ENCODING, TOPIC};
    use support::error::{Error, Result};

    use crate::lines::{cells, names};

    /// Listens from [`open`](Self::open) on, and has a channel from the first lines on.
    pub struct LiveView {
        host: String,
        server: WebSocketServerHandle,
        context: Arc<Context>,
        channel: Option<(Arc<RawChannel>, JsonRows)>,
    }

    fn failed(error: &dyn std::fmt::Display) -> Error {
        Error::failed(format!("--foxglove: {error}"))
    }

    impl LiveView {
        /// Listens at `HOST:PORT`; port 0 is any free one.
        ///
        /// # Errors
        /// No such address; one that is not this machine's or is in use (wrong usage).
        pub fn open(address: &str) -> Result<Self> {
            let wrong = |why: &dyn std::fmt::Display| {
                Error::usage(format!(
                    "--foxglove {address}: {why}; expected HOST:PORT, as {}",
                    super::ADDRESS
                ))
            };
            let (host, port) = address.rsplit_once(':').ok_or_else(|| wrong(&"has no port"))?;
            let port = port.parse().map_err(|_| wrong(&"its port is no number from 0 to 65535"))?;
            let context = Context::new();
            let server = context.websocket_server().name("gmr record").bind(host, port).start_blocking();
            let server = server.map_err(|error| wrong(&error))?;
            Ok(Self { host: host.to_owned(), server, context, channel: None })
        }

        /// Where clients find it.
        pub fn url(&self) -> String {
            format!("ws://{}:{}", self.host, self.server.port())
        }

        /// Sends whole lines. The first is the header. That nobody listens, or leaves, is no error.
        ///
        /// # Errors
        /// A header without time.
        pub fn append(&mut self, lines: &str) -> Result<()> {
            let mut lines = lines.lines();
            let (channel, rows) = match &mut self.channel {
                Some(open) => open,
                none => none.insert(begin(&self.context, lines.next().unwrap_or(""))?),
            };
            for line in lines {
                let row = rows.row(&cells(line)).map_err(|error| failed(&error))?;
                channel.log_with_meta(row.message, PartialMetadata::with_log_time(row.time_ns));
            }
            Ok(())
        }

        /// Sends the clients away.
        pub fn finish(self) {
            self.server.stop().wait_blocking();
        }
    }

    fn begin(context: &Arc<Context>, header: &str) -> Result<(Arc<RawChannel>, JsonRows)> {
        let names = names(header);
        let rows = JsonRows::new(&names, &vec![false; names.len()]).map_err(|error| failed(&error))?;
        let schema = Schema::new(SCHEMA, SCHEMA_ENCODING, rows.schema().into_bytes());
        let channel = ChannelBuilder::new(TOPIC).context(context).message_encoding(ENCODING).schema(schema);
        Ok((channel.build_raw().map_err(|error| failed(&error))?, rows))
    }
}

#[cfg(not(feature = "foxglove"))]
mod absent {
    use support::error::{Error, Result};

    /// There is none.
    pub enum LiveView {}

    impl LiveView {
        /// Says how to build with it.
        ///
        /// # Errors
        /// Always (wrong usage).
        pub fn open(_: &str) -> Result<Self> {
            Err(Error::usage(
                "--foxglove: this gmr was built without Foxglove's WebSocket; expected one built with \
                 `cargo install --path host-tools --features foxglove` (or gmr watch --udp, which PlotJuggler hears)",
            ))
        }

        /// Nowhere.
        pub fn url(&self) -> String {
            match *self {}
        }

        /// To no client.
        ///
        /// # Errors
        /// None.
        pub fn append(&mut self, _: &str) -> Result<()> {
            match *self {}
        }

        /// Of nothing.
        pub fn finish(self) {
            match self {}
        }
    }
}

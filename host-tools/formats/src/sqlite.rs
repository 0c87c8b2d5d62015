//! Bags of ROS 2 in SQLite: the tables `topics`, `messages` and, since ROS 2 Iron,
//! `message_definitions` (rosbag2_storage_sqlite3).

use std::collections::HashMap;
use std::path::Path;

use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags};

use crate::cdr;
use crate::ending::{Each, Ending};
use crate::error::{Error, Result};
use crate::topic::{Encoding, Serialization, Topic};

fn damaged(error: rusqlite::Error) -> Error {
    match error {
        rusqlite::Error::SqliteFailure(code, _) if code.code == rusqlite::ErrorCode::DatabaseCorrupt => Error::Truncated(
            "is a damaged SQLite file, or one that was cut off; expected a whole one (sqlite3 FILE .recover)".to_owned(),
        ),
        error => Error::damaged("SQLite", error),
    }
}

fn open(path: &Path) -> Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    Connection::open_with_flags(path, flags).map_err(damaged)
}

fn has_table(connection: &Connection, name: &str) -> Result<bool> {
    let query = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = ?1";
    let count: i64 = connection.query_row(query, [name], |row| row.get(0)).map_err(damaged)?;
    Ok(count > 0)
}

/// The topics, with their definitions.
pub(crate) fn topics(path: &Path) -> Result<Vec<Topic>> {
    let connection = open(path)?;
    if !has_table(&connection, "topics")? || !has_table(&connection, "messages")? {
        let message = "is an SQLite file without the tables topics and messages; expected a bag of ROS 2";
        return Err(Error::Unsupported(message.to_owned()));
    }
    let definitions = definitions(&connection)?;
    let mut statement = connection
        .prepare("SELECT name, type, serialization_format FROM topics ORDER BY id")
        .map_err(damaged)?;
    let rows = statement.query_map([], |row| {
        Ok((row.get::<_, String>(0)?, row.get::<_, String>(1)?, row.get::<_, String>(2)?))
    });
    let mut topics: Vec<Topic> = Vec::new();
    for row in rows.map_err(damaged)? {
        let (name, kind, format) = row.map_err(damaged)?;
        if topics.iter().any(|known| known.name == name) {
            continue;
        }
        let definition = definitions.get(&kind).cloned().or_else(|| cdr::known_definition(&kind));
        let encoding = match definition {
            Some(definition) if format == "cdr" => {
                Encoding::Ros { definition, serialization: Serialization::Cdr }
            }
            None if format == "cdr" => Encoding::Other("cdr without a definition in the bag".to_owned()),
            _ => Encoding::Other(format),
        };
        topics.push(Topic { name, kind, encoding, messages: None });
    }
    Ok(topics)
}

/// By type.
fn definitions(connection: &Connection) -> Result<HashMap<String, String>> {
    let mut definitions = HashMap::new();
    if !has_table(connection, "message_definitions")? {
        return Ok(definitions);
    }
    let query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions";
    let mut statement = connection.prepare(query).map_err(damaged)?;
    let rows = statement.query_map([], |row| {
        Ok((row.get::<_, String>(0)?, row.get::<_, String>(1)?, row.get::<_, String>(2)?))
    });
    for row in rows.map_err(damaged)? {
        let (kind, encoding, definition) = row.map_err(damaged)?;
        if encoding == "ros2msg" && !definition.trim().is_empty() {
            definitions.insert(kind, definition);
        }
    }
    Ok(definitions)
}

/// Hands out the messages of some topics.
pub(crate) fn read(path: &Path, topics: &[Topic], wanted: &[usize], each: &mut Each<'_>) -> Result<Ending> {
    let connection = open(path)?;
    let mut places: HashMap<i64, usize> = HashMap::new();
    let mut statement = connection.prepare("SELECT id, name FROM topics").map_err(damaged)?;
    let rows = statement.query_map([], |row| Ok((row.get::<_, i64>(0)?, row.get::<_, String>(1)?)));
    for row in rows.map_err(damaged)? {
        let (id, name) = row.map_err(damaged)?;
        let place = topics.iter().position(|topic| topic.name == name);
        if let Some(place) = place.filter(|place| wanted.contains(place)) {
            places.insert(id, place);
        }
    }
    // In the order of time: there is an index by it, and recorders write nearly so.
    let query = "SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp";
    let mut statement = connection.prepare(query).map_err(damaged)?;
    let mut rows = statement.query([]).map_err(damaged)?;
    loop {
        let row = match rows.next() {
            Ok(Some(row)) => row,
            Ok(None) => return Ok(Ending::Whole),
            Err(error) => {
                return Ok(Ending::Cut(format!(
                    "breaks off ({error}); --allow-truncated reads what comes before"
                )));
            }
        };
        let Some(place) = places.get(&row.get(0).map_err(damaged)?) else { continue };
        let received: i64 = row.get(1).map_err(damaged)?;
        let ValueRef::Blob(message) = row.get_ref(2).map_err(damaged)? else {
            return Err(Error::Damaged("has a message that is no bytes; expected a bag of ROS 2".to_owned()));
        };
        if !each(*place, received, message)? {
            return Ok(Ending::Whole);
        }
    }
}

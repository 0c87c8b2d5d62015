//! The power that `[topics]` of robot.toml names, heard: messages of whatever type, by the
//! definitions that are known.

use std::convert::Infallible;

use log_formats::{Extractor, Topic};
use logs::robot::Robot;
use rustdds::RepresentationIdentifier;
use rustdds::no_key::{DataReader, Decode, DefaultDecoder, DeserializerAdapter};
use support::error::Result;

use super::Domain;
use crate::power::{PowerSource, Reading};
use crate::sum::Sum;

/// A topic's type is looked for this often, s.
const LOOK_S: f64 = 0.1;

/// Messages of motor drivers, added up.
pub struct RosPower {
    domain: Domain,
    sum: Sum,
    /// Of each topic of the sum, once somebody sends it.
    heard: Vec<Option<Heard>>,
    looked_s: f64,
    undecoded: u64,
}

struct Heard {
    reader: DataReader<Vec<u8>, Raw>,
    extractor: Extractor,
}

impl RosPower {
    pub(super) fn of(domain: Domain, robot: &Robot) -> Result<Self> {
        let sum = Sum::of(robot)?;
        let heard = sum.topics.iter().map(|_| None).collect();
        Ok(Self { domain, sum, heard, looked_s: f64::NEG_INFINITY, undecoded: 0 })
    }

    /// Types are the senders' to tell.
    fn look(&mut self, now_s: f64) -> Result<()> {
        if now_s - self.looked_s < LOOK_S || self.heard.iter().all(Option::is_some) {
            return Ok(());
        }
        self.looked_s = now_s;
        let writers = self.domain.participant.discovered_writers();
        for topic in 0..self.heard.len() {
            let name = self.sum.topics[topic].name.clone();
            let in_dds = format!("rt{name}");
            let told = writers.iter().map(|writer| &writer.publication_topic_data);
            let Some(told) =
                told.filter(|_| self.heard[topic].is_none()).find(|told| told.topic_name == in_dds)
            else {
                continue;
            };
            let kind = told.type_name.replace("::dds_::", "::").replace("::", "/");
            let known = Topic::known(&name, kind.trim_end_matches('_'));
            match known.and_then(|topic_of| Extractor::new(&topic_of, &self.sum.fields(topic))) {
                Ok(extractor) => {
                    let reader = self.domain.reader(&name, &told.type_name)?;
                    self.heard[topic] = Some(Heard { reader, extractor });
                    self.sum.topics[topic].unreadable = None;
                }
                Err(why) => self.sum.topics[topic].unreadable = Some(why.to_string()),
            }
        }
        Ok(())
    }
}

impl PowerSource for RosPower {
    fn take(&mut self, now: f64) -> Result<Vec<(f64, Reading)>> {
        self.look(now)?;
        for (topic, heard) in self.heard.iter_mut().enumerate() {
            let Some(Heard { reader, extractor }) = heard else { continue };
            while let Ok(Some(sample)) = reader.take_next_sample() {
                match extractor.numbers(&sample.into_value()) {
                    Ok(numbers) => self.sum.take(topic, now, numbers),
                    Err(_) => self.undecoded += 1,
                }
            }
        }
        // Held until the next message, so that the mean over a sample is one over time.
        Ok(self.sum.reading(now).map(|reading| (now, reading)).into_iter().collect())
    }

    fn missing(&self, now: f64) -> Option<String> {
        self.sum.missing(now)
    }

    fn faults(&self) -> Vec<(&'static str, u64)> {
        let faults = [("messages of power that are not of their type", self.undecoded)];
        faults.into_iter().filter(|(_, count)| *count > 0).collect()
    }
}

/// A message as it came, with the four bytes in front that say how it is written.
#[derive(Debug, Clone, Copy)]
struct Raw;

impl DeserializerAdapter<Vec<u8>> for Raw {
    type Error = Infallible;
    type Decoded = Vec<u8>;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[RepresentationIdentifier::CDR_LE, RepresentationIdentifier::CDR_BE]
    }

    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

impl DefaultDecoder<Vec<u8>> for Raw {
    type Decoder = Self;
    const DECODER: Self = Self;
}

impl Decode<'_, Vec<u8>> for Raw {
    type Error = Infallible;

    fn decode_bytes(
        self,
        bytes: &[u8],
        encoding: RepresentationIdentifier,
    ) -> std::result::Result<Vec<u8>, Infallible> {
        let is_little = encoding == RepresentationIdentifier::CDR_LE;
        Ok([&[0, u8::from(is_little), 0, 0], bytes].concat())
    }
}

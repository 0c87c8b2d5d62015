//! ROS 2 without a ROS installation: topics as DDS has them, through RustDDS.
//!
//! A topic `/a` of ROS is `rt/a` in DDS, a type `p/msg/T` is `p::msg::dds_::T_`, and messages are
//! plain CDR (design.ros2.org/articles/topic_and_service_names). Lost peers, new ones and their
//! discovery are RustDDS's.

mod messages;
mod power;

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{SystemTime, UNIX_EPOCH};

use logs::robot::{NodeSettings, Robot};
use rustdds::no_key::{DataReader, DataReaderCdr, DataWriterCdr, DeserializerAdapter};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, Duration, GUID, QosPolicies, QosPolicyBuilder,
    RTPSEntity as _, TopicKind,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use support::error::{Error, Result};

use self::messages::{
    BatteryState, DiagnosticArray, Float64, Gid, JointState, Odometry, ParticipantEntitiesInfo, Time,
};
pub use self::power::RosPower;
use super::wheels::{Motion, WheelMessage};
use super::{Outlet, State, WheelSource};

const JOINT_STATE: &str = "sensor_msgs::msg::dds_::JointState_";
const ODOMETRY: &str = "nav_msgs::msg::dds_::Odometry_";
const BATTERY_STATE: &str = "sensor_msgs::msg::dds_::BatteryState_";
const FLOAT64: &str = "std_msgs::msg::dds_::Float64_";
const DIAGNOSTIC_ARRAY: &str = "diagnostic_msgs::msg::dds_::DiagnosticArray_";

const ENTITIES: &str = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";

/// What `ros2 node list` shows.
const NODE: &str = "gmr_node";

/// As ROS 2 keeps messages unless told otherwise.
const DEPTH: i32 = 10;

fn failed(what: &str, error: impl std::fmt::Display) -> Error {
    Error::failed(format!("DDS: {what}: {error}"))
}

/// A DDS domain that was joined.
#[derive(Clone)]
pub struct Domain {
    participant: DomainParticipant,
    settings: NodeSettings,
    entities: Rc<RefCell<Entities>>,
}

/// What of the domain is the node's.
#[derive(Default)]
struct Entities {
    readers: Vec<GUID>,
    writers: Vec<GUID>,
}

impl Domain {
    /// Joins the domain of a number, `ROS_DOMAIN_ID`.
    ///
    /// # Errors
    /// No network.
    pub fn join(robot: &Robot, number: u16) -> Result<Self> {
        let participant = DomainParticipantBuilder::new(number)
            .build()
            .map_err(|error| failed(&format!("domain {number} cannot be joined"), error))?;
        Ok(Self { participant, settings: robot.node().clone(), entities: Rc::default() })
    }

    fn qos(reliability: Reliability) -> QosPolicies {
        QosPolicyBuilder::new()
            .reliability(reliability)
            .durability(Durability::Volatile)
            .history(History::KeepLast { depth: DEPTH })
            .build()
    }

    fn topic(&self, name: &str, kind: &str, qos: &QosPolicies) -> Result<rustdds::Topic> {
        self.participant
            .create_topic(name.to_owned(), kind.to_owned(), qos, TopicKind::NoKey)
            .map_err(|error| failed(name, error))
    }

    fn writer<M: Serialize>(&self, name: &str, kind: &str) -> Result<DataWriterCdr<M>> {
        // What is offered reliably is heard by those who ask for less as well.
        let qos = Self::qos(Reliability::Reliable { max_blocking_time: Duration::from_millis(10) });
        let writer = self.writer_of(&format!("rt{name}"), kind, &qos)?;
        self.entities.borrow_mut().writers.push(writer.guid());
        Ok(writer)
    }

    fn writer_of<M: Serialize>(&self, name: &str, kind: &str, qos: &QosPolicies) -> Result<DataWriterCdr<M>> {
        let topic = self.topic(name, kind, qos)?;
        let publisher = self.participant.create_publisher(qos).map_err(|error| failed(name, error))?;
        publisher.create_datawriter_no_key_cdr(&topic, None).map_err(|error| failed(name, error))
    }

    /// Says of which node all that is, as ROS's own nodes do (`rmw_dds_common`).
    fn graph<G: Serialize>(&self) -> Result<DataWriterCdr<ParticipantEntitiesInfo<G>>> {
        let qos = QosPolicyBuilder::new()
            .reliability(Reliability::Reliable { max_blocking_time: Duration::from_millis(10) })
            .durability(Durability::TransientLocal)
            .history(History::KeepLast { depth: 1 })
            .build();
        self.writer_of("ros_discovery_info", ENTITIES, &qos)
    }

    fn reader<M, A>(&self, name: &str, kind: &str) -> Result<DataReader<M, A>>
    where
        M: 'static,
        A: DeserializerAdapter<M> + 'static,
    {
        // Every sender offers at least this; a speed that comes late is of no use.
        let qos = Self::qos(Reliability::BestEffort);
        let topic = self.topic(&format!("rt{name}"), kind, &qos)?;
        let subscriber = self.participant.create_subscriber(&qos).map_err(|error| failed(name, error))?;
        let reader: DataReader<M, A> =
            subscriber.create_datareader_no_key(&topic, None).map_err(|error| failed(name, error))?;
        self.entities.borrow_mut().readers.push(reader.guid());
        Ok(reader)
    }

    /// Hears the power that robot.toml names.
    ///
    /// # Errors
    /// It names none.
    pub fn power(&self, robot: &Robot) -> Result<RosPower> {
        RosPower::of(self.clone(), robot)
    }

    /// Hears of the wheels.
    ///
    /// # Errors
    /// DDS refuses.
    pub fn wheels(&self) -> Result<RosWheels> {
        Ok(RosWheels(match &self.settings.odometry {
            Some(odometry) => Source::Odometry(self.reader(odometry, ODOMETRY)?),
            None => Source::Joints(self.reader(&self.settings.joint_states, JOINT_STATE)?),
        }))
    }

    /// Tells what the node knows.
    ///
    /// # Errors
    /// DDS refuses.
    pub fn outlet(self, robot: &Robot) -> Result<RosOutlet> {
        let node = &self.settings;
        Ok(RosOutlet {
            battery: self.writer(&node.battery_state, BATTERY_STATE)?,
            diagnostics: self.writer(&node.diagnostics, DIAGNOSTIC_ARRAY)?,
            numbers: [
                self.writer(&node.payload, FLOAT64)?,
                self.writer(&node.payload_low, FLOAT64)?,
                self.writer(&node.payload_high, FLOAT64)?,
                self.writer(&node.measured_power, FLOAT64)?,
                self.writer(&node.predicted_power, FLOAT64)?,
                self.writer(&node.remaining_energy, FLOAT64)?,
                self.writer(&node.remaining_time, FLOAT64)?,
            ],
            capacity_ah: robot.battery().map(|pack| pack.capacity / 3600.0),
            cells: robot.battery().map_or(0, |pack| pack.cells as usize),
            name: robot.name().to_owned(),
            others: false,
            graph: Graph::of(&self)?,
            announced: 0,
            domain: self,
        })
    }
}

/// Messages of joints or of odometry.
pub struct RosWheels(Source);

enum Source {
    Joints(DataReaderCdr<JointState>),
    Odometry(DataReaderCdr<Odometry>),
}

fn taken<M: DeserializeOwned + 'static>(reader: &mut DataReaderCdr<M>, mut each: impl FnMut(M, [u8; 16])) {
    // What cannot be decoded is not of this type, and none of ours.
    while let Ok(Some(sample)) = reader.take_next_sample() {
        let from = sample.sample_info().publication_handle().to_bytes();
        each(sample.into_value(), from);
    }
}

impl WheelSource for RosWheels {
    fn take(&mut self) -> Vec<WheelMessage> {
        let mut messages = Vec::new();
        match &mut self.0 {
            Source::Joints(reader) => taken(reader, |joints, from| {
                let motion = Motion::Joints(joints.name, joints.velocity);
                messages.push(WheelMessage { from, stamp_s: joints.header.stamp.seconds(), motion });
            }),
            Source::Odometry(reader) => taken(reader, |odometry, from| {
                let stamp_s = odometry.header.stamp.seconds();
                messages.push(WheelMessage { from, stamp_s, motion: Motion::Twist(odometry.planar()) });
            }),
        }
        messages
    }
}

/// All topics that a node tells.
pub struct RosOutlet {
    battery: DataWriterCdr<BatteryState>,
    diagnostics: DataWriterCdr<DiagnosticArray>,
    numbers: [DataWriterCdr<Float64>; 7],
    capacity_ah: Option<f64>,
    cells: usize,
    name: String,
    /// That somebody else tells of the battery has been said.
    others: bool,
    graph: Graph,
    /// How many entities have been told of.
    announced: usize,
    domain: Domain,
}

/// As the releases of ROS 2 write it.
enum Graph {
    Since(DataWriterCdr<ParticipantEntitiesInfo<Gid<16>>>),
    Before(DataWriterCdr<ParticipantEntitiesInfo<Gid<24>>>),
}

impl Graph {
    /// By `ROS_DISTRO`: nothing on the network tells the two from each other.
    fn of(domain: &Domain) -> Result<Self> {
        let is_before = std::env::var("ROS_DISTRO").is_ok_and(|name| BEFORE_IRON.contains(&&*name));
        Ok(if is_before { Self::Before(domain.graph()?) } else { Self::Since(domain.graph()?) })
    }

    fn tell(&self, participant: GUID, Entities { readers, writers }: &Entities) {
        // As with the topics: what DDS did not take is not sent again.
        let _ = match self {
            Self::Since(to) => {
                to.write(ParticipantEntitiesInfo::of(participant, NODE, readers, writers), None).is_ok()
            }
            Self::Before(to) => {
                to.write(ParticipantEntitiesInfo::of(participant, NODE, readers, writers), None).is_ok()
            }
        };
    }
}

/// Releases of ROS 2 whose `Gid` has 24 bytes.
const BEFORE_IRON: [&str; 3] = ["foxy", "galactic", "humble"];

impl Outlet for RosOutlet {
    fn publish(&mut self, state: &State) -> Result<()> {
        let entities = self.domain.entities.borrow();
        let count = entities.readers.len() + entities.writers.len();
        if count != self.announced {
            self.announced = count;
            self.graph.tell(self.domain.participant.guid(), &entities);
        }
        drop(entities);
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let stamp =
            Time { sec: i32::try_from(now.as_secs()).unwrap_or(i32::MAX), nanosec: now.subsec_nanos() };
        // What DDS did not take is not sent again: a full queue empties itself, and the next state
        // is newer.
        let _ = self.battery.write(BatteryState::of(state, stamp, self.capacity_ah, self.cells), None);
        let _ = self.diagnostics.write(DiagnosticArray::of(state, stamp, &self.name), None);
        let numbers = [
            state.payload_kg,
            state.payload_low_kg,
            state.payload_high_kg,
            state.measured_w,
            state.predicted_w,
            state.remaining_j,
            state.remaining_s,
        ];
        for (writer, number) in self.numbers.iter().zip(numbers) {
            let _ = writer.write(Float64 { data: number.unwrap_or(f64::NAN) }, None);
        }
        Ok(())
    }

    /// Two senders of one topic contradict each other, and nobody sees who is who.
    fn trouble(&mut self) -> Option<String> {
        let topic = &self.domain.settings.battery_state;
        let name = format!("rt{topic}");
        let ours = self.domain.participant.guid().prefix;
        let is_other = |writer: &rustdds::discovery::DiscoveredWriterData| {
            let told = &writer.publication_topic_data;
            told.topic_name == name && told.key.prefix != ours
        };
        if self.others || !self.domain.participant.discovered_writers().iter().any(is_other) {
            return None;
        }
        self.others = true;
        Some(format!(
            "somebody else publishes {topic} as well; expected another battery_state in [node] of robot.toml, or that one switched off"
        ))
    }
}

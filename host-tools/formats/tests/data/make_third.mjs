// Writes core-*.mcap: the first 200 rows of drive.csv by a third writer that is not ours, MCAP's in TypeScript, in the forms that recorders leave.
//
//     npm install @mcap/core@2.2.2 @foxglove/rosmsg@5.0.5 @foxglove/rosmsg-serialization@2.0.4 \
//         @foxglove/rosmsg2-serialization@3.1.0 @foxglove/wasm-zstd@1.0.1
//     node make_third.mjs
//
// core-zstd    small chunks in zstd, every index
// core-bare    chunks as they are, without any index, statistics or summary: as of a recorder that cannot seek
// core-plain   no chunks
// core-ros1    ROS 1's messages and definitions, as `mcap convert` makes them of its bags

import fs from "node:fs";
import path from "node:path";

import { McapWriter } from "@mcap/core";
import { parse } from "@foxglove/rosmsg";
import { MessageWriter as Ros1Writer } from "@foxglove/rosmsg-serialization";
import { MessageWriter as Ros2Writer } from "@foxglove/rosmsg2-serialization";
import zstd from "@foxglove/wasm-zstd";

const HERE = import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname);
const ROWS = 200;
const START = 1_760_000_000_000_000_000n;
const BORDER = "=".repeat(80);
const JOINTS = "Header header\n\nstring[] name # of each\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n";
const ROS1_JOINTS = `${JOINTS}${BORDER}\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n`;
const ROS2_JOINTS =
  `${JOINTS.replace("Header", "std_msgs/Header")}${BORDER}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n` +
  `${BORDER}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n`;
const NUMBER = "float64 data\n";

class Sink {
  parts = [];
  length = 0n;
  async write(bytes) {
    this.parts.push(bytes.slice());
    this.length += BigInt(bytes.byteLength);
  }
  position() {
    return this.length;
  }
}

function rows() {
  const [header, ...lines] = fs.readFileSync(path.join(HERE, "drive.csv"), "utf8").trim().split("\n");
  if (header !== "time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg") throw new Error(header);
  return lines.slice(0, ROWS).map((line) => line.split(",").map(Number));
}

async function write(name, isRos1, options) {
  const sink = new Sink();
  const writer = new McapWriter({ writable: sink, ...options });
  await writer.start({ profile: isRos1 ? "ros1" : "ros2", library: "" });
  const of = (text) => parse(text, { ros2: !isRos1 });
  const Writer = isRos1 ? Ros1Writer : Ros2Writer;
  const kind = (name) => (isRos1 ? name : name.replace("/", "/msg/"));
  const topics = [];
  for (const [topic, type, text] of [
    ["/joint_states", "sensor_msgs/JointState", isRos1 ? ROS1_JOINTS : ROS2_JOINTS],
    ["/power", "std_msgs/Float64", NUMBER],
    ["/total_mass", "std_msgs/Float64", NUMBER],
  ]) {
    const data = new TextEncoder().encode(text);
    const schemaId = await writer.registerSchema({ name: kind(type), encoding: isRos1 ? "ros1msg" : "ros2msg", data });
    const messageEncoding = isRos1 ? "ros1" : "cdr";
    const id = await writer.registerChannel({ topic, schemaId, messageEncoding, metadata: new Map() });
    topics.push({ id, encode: new Writer(of(text)) });
  }
  for (const [sequence, [time, left, right, power, mass]] of rows().entries()) {
    const at = START + BigInt(Math.round(time * 1e9));
    const [sec, nsec] = [Number(at / 1_000_000_000n), Number(at % 1_000_000_000n)];
    const header = { seq: sequence, stamp: { sec, nsec, nanosec: nsec }, frame_id: "base" };
    const joints = { header, name: ["wheel_left_joint", "wheel_right_joint"], position: [0, 0], velocity: [left, right], effort: [] };
    for (const [place, message] of [joints, { data: power }, { data: mass }].entries()) {
      const { id, encode } = topics[place];
      await writer.addMessage({ channelId: id, sequence, logTime: at, publishTime: at, data: encode.writeMessage(message) });
    }
  }
  await writer.end();
  fs.writeFileSync(path.join(HERE, name), Buffer.concat(sink.parts));
}

await zstd.isLoaded;
const packed = { chunkSize: 8192, compressChunk: (data) => ({ compression: "zstd", compressedData: zstd.compress(data, 9) }) };
const none = {
  useStatistics: false, useSummaryOffsets: false, repeatSchemas: false, repeatChannels: false, useMessageIndex: false, useChunkIndex: false,
  useAttachmentIndex: false, useMetadataIndex: false,
};
await write("core-zstd.mcap", false, packed);
await write("core-bare.mcap", false, { chunkSize: 8192, ...none });
await write("core-plain.mcap", false, { useChunks: false });
await write("core-ros1.mcap", true, packed);

// node recording.mjs BUILD FOLDER: a reel as a recording of ROS 2, read by the libraries of Foxglove.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { open, readFile } from "node:fs/promises";
import { join } from "node:path";
import { test } from "node:test";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import rosmsg from "@foxglove/rosmsg";
import ros2 from "@foxglove/rosmsg2-serialization";
import { decompress } from "fzstd";

const [build, folder] = process.argv.slice(2);
const frames = 8;  // zstd in JavaScript is slow
const timeOf = (frame) => BigInt(Math.round(frame * 1e6 / 30)) * 1000n;
const server = join(build, "bin/pointreel-server");
const unpack = (format) => {
  const out = join(folder, format);
  execFileSync(server, ["unpack", "-i", join(folder, "reel"), "-o", out, "--format", format,
    "--frames", `0-${frames - 1}`]);
  return out;
};
const path = join(unpack("mcap"), "recording.mcap");
const decompressHandlers = { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) };

/** The points of a frame as PCD has them. */
async function pcd(frame) {
  const bytes = await readFile(join(unpack("pcd"), `frame_${String(frame).padStart(5, "0")}.pcd`));
  const mark = "DATA binary\n";
  return bytes.subarray(bytes.indexOf(mark) + mark.length);
}

function decoder(schema) {
  const reader = new ros2.MessageReader(rosmsg.parse(new TextDecoder().decode(schema.data), { ros2: true }));
  return (message) => reader.readMessage(message.data);
}

test("readers seek by the index", async () => {
  const file = await open(path);
  let fetched = 0;
  const { size } = await file.stat();
  const readable = {
    size: async () => BigInt(size),
    read: async (offset, length) => {
      fetched += Number(length);
      const bytes = new Uint8Array(Number(length));
      await file.read(bytes, 0, Number(length), Number(offset));
      return bytes;
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  assert.equal(reader.header.profile, "ros2");
  assert.equal(reader.statistics.messageCount, BigInt(frames));
  assert.equal(reader.chunkIndexes.length, frames);
  const [channel] = reader.channelsById.values();
  assert.equal(channel.topic, "/points");
  const schema = reader.schemasById.get(channel.schemaId);
  assert.equal(schema.name, "sensor_msgs/msg/PointCloud2");
  const at = timeOf(5), seen = [];
  for await (const message of reader.readMessages({ startTime: at, endTime: at + 1000n })) seen.push(message);
  assert.equal(seen.length, 1);
  assert.ok(fetched < size / 4, `${fetched} of ${size} bytes`);
  const cloud = decoder(schema)(seen[0]);
  assert.deepEqual(cloud.header, { stamp: { sec: 0, nanosec: Number(at) }, frame_id: "map" });
  assert.equal(cloud.data.length, cloud.width * cloud.point_step);
  assert.deepEqual(cloud.fields.map(({ name, offset }) => [name, offset]),
    [["x", 0], ["y", 4], ["z", 8], ["normal_x", 12], ["normal_y", 16], ["normal_z", 20], ["rgb", 24]]);
  assert.ok(Buffer.from(cloud.data).equals(await pcd(5)));
  await file.close();
});

test("readers of streams check every checksum and find each frame at its time", async () => {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true, includeChunks: true });
  reader.append(await readFile(path));
  const times = [];
  for (let record = reader.nextRecord(); record; record = reader.nextRecord())
    if (record.type === "Message") times.push(record.logTime);
  assert.ok(reader.done());
  assert.deepEqual(times, Array.from({ length: frames }, (_, i) => timeOf(i)));
});

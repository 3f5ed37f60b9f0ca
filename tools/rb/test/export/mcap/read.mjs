// Reads an MCAP file with @mcap/core: read.mjs FILE VALUES
//
// Standard output: one JSON object: topics (schema, messages), metadata, attachments.  VALUES gets, for each message of
// a topic of samples, its log time (ns, 64 bits) and its numbers (doubles), little endian.
import { createWriteStream } from "node:fs";
import { open } from "node:fs/promises";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";

const [path, values] = process.argv.slice(2);
const file = await open(path);
const size = BigInt((await file.stat()).size);

// Front to back, every CRC checked.
const counted = {};
const stream = new McapStreamReader({ validateCrcs: true });
for await (const part of file.createReadStream({ autoClose: false, start: 0 })) {
  stream.append(part);
  for (let record; (record = stream.nextRecord()); )
    if (record.type === "Message") counted[record.channelId] = (counted[record.channelId] ?? 0) + 1;
}
if (!stream.done()) throw new Error("does not end as MCAP does");

// By the index, as Foxglove opens it.
const reader = await McapIndexedReader.Initialize({
  readable: {
    size: async () => size,
    read: async (offset, length) => {
      const buffer = new Uint8Array(Number(length));
      const { bytesRead } = await file.read(buffer, 0, buffer.length, Number(offset));
      if (bytesRead !== buffer.length) throw new Error(`${bytesRead} of ${length} bytes at ${offset}`);
      return buffer;
    },
  },
});
const found = { topics: {}, metadata: {}, attachments: {}, marks: [] };
for (const { id, topic, schemaId, messageEncoding } of reader.channelsById.values()) {
  const { name, encoding, data } = reader.schemasById.get(schemaId);
  const text = new TextDecoder().decode(data);
  found.topics[topic] = { name, encoding, text, messageEncoding, streamed: counted[id], messages: 0,
    stated: Number(reader.statistics.channelMessageCounts.get(id)) };
}
const out = createWriteStream(values);
for await (const message of reader.readMessages()) {
  const { topic } = reader.channelsById.get(message.channelId);
  const view = new DataView(message.data.buffer, message.data.byteOffset, message.data.byteLength);
  if (view.getUint32(0) !== 0x00010000) throw new Error("not CDR, little endian");
  found.topics[topic].messages += 1;
  if (topic === "/marks") {
    const length = view.getUint32(12, true);
    const text = new TextDecoder().decode(message.data.subarray(16, 16 + length - 1));
    found.marks.push({ time_ns: String(message.logTime), number: Number(view.getBigInt64(4, true)), text });
    continue;
  }
  const time = new DataView(new ArrayBuffer(8));
  time.setBigInt64(0, message.logTime, true);
  out.write(new Uint8Array(time.buffer));
  out.write(message.data.slice(4));
}
await new Promise((done) => out.end(done));
for await (const { name, metadata } of reader.readMetadata()) found.metadata[name] = Object.fromEntries(metadata);
for await (const { name, data } of reader.readAttachments()) found.attachments[name] = new TextDecoder().decode(data);
console.log(JSON.stringify(found));

// Logs made by hand, with what the program writes of objects. The format of the file is that of mcap.dev/spec.

const MAGIC = Buffer.from([0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a]);

const number = (bytes, write) => {
  const field = Buffer.alloc(bytes);
  write(field);
  return field;
};
const u16 = (value) => number(2, (field) => field.writeUInt16LE(value));
const u32 = (value) => number(4, (field) => field.writeUInt32LE(value));
const u64 = (value) => number(8, (field) => field.writeBigUInt64LE(BigInt(Math.round(value))));
const sized = (bytes) => Buffer.concat([u32(bytes.length), bytes]);
const text = (value) => sized(Buffer.from(value));
const record = (opcode, ...fields) => {
  const body = Buffer.concat(fields);
  return Buffer.concat([Buffer.of(opcode), u64(body.length), body]);
};

/** A log of chunks, each of which is a list of messages `{ topic, time, data }` with s; `metadata` is that of the run. */
export function writeLog(metadata, chunks) {
  const parts = [];
  let length = 0;
  const add = (bytes) => {
    parts.push(bytes);
    length += bytes.length;
    return length - bytes.length;
  };
  add(MAGIC);
  add(record(0x01, text(''), text('test')));
  const entries = Object.entries(metadata).flatMap(([key, value]) => [text(key), text(value)]);
  const run = record(0x0c, text('run'), sized(Buffer.concat(entries)));
  const index = [record(0x0d, u64(add(run)), u64(run.length), text('run'))];
  const topics = new Map();
  for (const messages of chunks) {
    const records = messages.flatMap(({ topic, time, data }) => {
      const isNew = !topics.has(topic);
      if (isNew) topics.set(topic, topics.size + 1);
      const channel = topics.get(topic);
      const described = record(0x04, u16(channel), u16(0), text(topic), text('protobuf'), u32(0));
      if (isNew) index.unshift(described);
      const message = record(0x05, u16(channel), u32(0), u64(time * 1e9), u64(time * 1e9), data);
      return isNew ? [described, message] : [message];
    });
    const bytes = Buffer.concat(records);
    const times = [messages[0].time, messages.at(-1).time].map((time) => u64(time * 1e9));
    const chunk = record(0x06, ...times, u64(bytes.length), u32(0), text(''), u64(bytes.length), bytes);
    const place = [u64(add(chunk)), u64(chunk.length)];
    const channels = [...new Set(messages.map(({ topic }) => topics.get(topic)))];
    channels.forEach((channel) => add(record(0x07, u16(channel), sized(Buffer.alloc(16)))));
    const offsets = sized(Buffer.concat(channels.flatMap((channel) => [u16(channel), u64(0)])));
    index.push(record(0x08, ...times, ...place, offsets));
  }
  add(record(0x0f, u32(0)));
  const summary = add(Buffer.concat(index));
  add(record(0x02, u64(summary), u64(0), u32(0)));
  add(MAGIC);
  return Buffer.concat(parts);
}

const varint = (value) => {
  const bytes = [];
  for (; value > 127; value = Math.floor(value / 128)) bytes.push((value % 128) | 128);
  return Buffer.of(...bytes, value);
};
/** Fields of a protobuf message; what is 0 or empty is left out. */
const whole = (field, value) => (value === 0 ? Buffer.alloc(0) : Buffer.concat([varint(8 * field), varint(value)]));
const inner = (field, bytes) => Buffer.concat([varint(8 * field + 2), varint(bytes.length), bytes]);
const doubles = (values) =>
  Buffer.concat(
    values.map((value, at) => {
      const field = number(9, (bytes) => bytes.writeDoubleLE(value, 1));
      field[0] = 8 * (at + 1) + 1;
      return value === 0 ? Buffer.alloc(0) : field;
    }),
  );

/** The messages that tell of objects, as crates/recorder/proto/usarsim.proto has them. */
export const message = {
  state: (time, place, object, pose) => {
    const parts = [whole(1, object), inner(3, doubles(pose.slice(0, 3))), inner(4, doubles(pose.slice(3)))];
    return { topic: `/map/object/${place}`, time, data: Buffer.concat(parts) };
  },
  spawned: (time, object, definition) => {
    const data = Buffer.concat([whole(1, object), inner(2, Buffer.from(definition))]);
    return { topic: '/objects/spawned', time, data };
  },
  removed: (time, object) => ({ topic: '/objects/removed', time, data: whole(1, object) }),
  line: (time) => ({ topic: '/wire/in', time, data: Buffer.concat([whole(1, 1), inner(3, Buffer.from('DRIVE'))]) }),
};

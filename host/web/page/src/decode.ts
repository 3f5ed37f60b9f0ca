// Decodes frames of rb-web (host/web/feed.hpp): messages as they were on the bus (common/wire).

/** How a message lies on the wire; made of its .lcm file by wire_types.mjs. */
export interface MessageType<T> {
  readonly fingerprint: string;  // its first eight bytes, hexadecimal
  readonly bytes: number;        // of the whole message
  readonly fields: readonly (readonly [name: string & keyof T, type: string, extents: readonly number[]])[];
}

/** A message and how long ago it was on the bus. */
export interface Arrival {
  readonly fingerprint: string;
  readonly ageMs: number;
  readonly bytes: DataView;
}

const kFrameMark = 0x52424631;

/** The messages of a frame.  Throws if it is none. */
export function readFrame(frame: ArrayBuffer): Arrival[] {
  const view = new DataView(frame);
  if (view.getUint32(0) !== kFrameMark) throw new Error("not a frame of this version");
  const arrivals: Arrival[] = [];
  let at = 8;
  for (let left = view.getUint32(4); left > 0; --left) {
    const ageMs = view.getUint32(at);
    const size = view.getUint32(at + 4);
    const bytes = new DataView(frame, at + 8, size);
    arrivals.push({ageMs, bytes, fingerprint: bytes.getBigUint64(0).toString(16).padStart(16, "0")});
    at += 8 + size;
  }
  return arrivals;
}

type Read = readonly [bytes: number, read: (view: DataView, at: number) => number];
// 64-bit numbers lose the bits beyond 53: nanoseconds are then exact to a quarter of a microsecond.
const kReaders: Readonly<Record<string, Read>> = {
  int8_t: [1, (view, at) => view.getInt8(at)],
  int16_t: [2, (view, at) => view.getInt16(at)],
  int32_t: [4, (view, at) => view.getInt32(at)],
  int64_t: [8, (view, at) => Number(view.getBigInt64(at))],
  float: [4, (view, at) => view.getFloat32(at)],
  double: [8, (view, at) => view.getFloat64(at)],
  byte: [1, (view, at) => view.getUint8(at)],
  boolean: [1, (view, at) => view.getInt8(at)],
};

/** The message that the bytes are.  Throws if they are another. */
export function decode<T>(type: MessageType<T>, arrival: Arrival): T {
  if (arrival.fingerprint !== type.fingerprint || arrival.bytes.byteLength !== type.bytes)
    throw new Error("a message of another type or size");
  let at = 8;
  const value = (name: string, extents: readonly number[]): unknown => {
    const [extent, ...inner] = extents;
    if (extent !== undefined) return Array.from({length: extent}, () => value(name, inner));
    const [bytes, read] = kReaders[name] as Read;
    at += bytes;
    return read(arrival.bytes, at - bytes);
  };
  const message: Record<string, unknown> = {};
  for (const [name, type_name, extents] of type.fields) message[name] = value(type_name, extents);
  return message as T;
}

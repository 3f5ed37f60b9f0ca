// A message as it goes on the bus: the inverse of decode.ts.
import type {MessageType} from "./decode";

type Write = readonly [bytes: number, write: (view: DataView, at: number, value: number) => void];
const kWriters: Readonly<Record<string, Write>> = {
  byte: [1, (view, at, value) => view.setUint8(at, value)],
  int32_t: [4, (view, at, value) => view.setInt32(at, value)],
  int64_t: [8, (view, at, value) => view.setBigInt64(at, BigInt(value))],
  float: [4, (view, at, value) => view.setFloat32(at, value)],
  double: [8, (view, at, value) => view.setFloat64(at, value)],
};

/** Arrays that are shorter than the message's are filled up with 0.  Throws if one is longer. */
export function encode<T>(type: MessageType<T>, message: T): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(type.bytes);
  const view = new DataView(bytes.buffer);
  view.setBigUint64(0, BigInt(`0x${type.fingerprint}`));
  let at = 8;
  const put = (value: unknown, name: string, extents: readonly number[]): void => {
    const [extent, ...inner] = extents;
    if (extent === undefined) {
      const writer = kWriters[name];
      if (!writer) throw new Error(`cannot write ${name}`);
      writer[1](view, at, typeof value === "number" ? value : 0);
      at += writer[0];
      return;
    }
    const values: unknown[] = Array.isArray(value) ? value : [];
    if (values.length > extent) throw new Error(`${values.length} values where ${extent} fit`);
    for (let k = 0; k < extent; ++k) put(values[k], name, inner);
  };
  for (const [name, type_name, extents] of type.fields) put(message[name], type_name, extents);
  return bytes;
}

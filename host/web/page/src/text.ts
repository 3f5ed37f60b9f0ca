// Texts of messages, which are bytes.

/** @param size  how many of them count */
export const utf8 = (bytes: readonly number[], size: number) => new TextDecoder().decode(new Uint8Array(bytes.slice(0, size)));

/** Of a field whose text ends where zeros begin. */
export function untilZero(bytes: readonly number[]): string {
  const end = bytes.indexOf(0);
  return utf8(bytes, end < 0 ? bytes.length : end);
}

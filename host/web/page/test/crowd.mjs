// The load that rb-web must bear: pages without a browser, some of which take nothing, and unwanted uploads.
import {connect} from "node:net";
import {once} from "node:events";
import {readFileSync} from "node:fs";
import {setTimeout as sleep} from "node:timers/promises";

const kUpload = Buffer.alloc(64 << 10);
const kAgainMs = 250;

/** Bytes of its own (anonymous, resident) that a living program has in memory. */
export const ownMemory = (pid) => 1024 * Number(/^RssAnon:\s*(\d+)/m.exec(readFileSync(`/proc/${pid}/status`, "latin1"))[1]);

/** What a program has once it has settled, and how much more it ever has later. */
export class MemoryTrend {
  settled = undefined;
  most = 0;
  #recent = [];
  /** @param looks  so many in a row count by the least: what is held for a moment only has not grown */
  constructor(settledAfterMs, looks = 1) {
    this.begin = performance.now() + settledAfterMs;
    this.looks = looks;
  }
  add(bytes) {
    if (performance.now() < this.begin) return;
    this.#recent = [...this.#recent, bytes].slice(-this.looks);
    if (this.#recent.length < this.looks) return;
    const least = Math.min(...this.#recent);
    this.settled ??= least;
    this.most = Math.max(this.most, least);
  }
  get growth() {
    return this.most - this.settled;
  }
  toString() {
    if (this.settled === undefined) return "not settled";
    const mib = (bytes) => (bytes / (1 << 20)).toFixed(2);
    return `${mib(this.settled)} MiB when settled, grew by ${mib(this.growth)} MiB`;
  }
}

const upgrade = (port) => `GET /feed HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\nOrigin: http://127.0.0.1:${port}\r\n` +
  "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n" +
  "Sec-WebSocket-Protocol: roadbalance\r\n\r\n";

/** Splits what comes from the server: first the head of its answer, then frames [opcode, payload]. */
class Splitter {
  #held = Buffer.alloc(0);
  #hasHead = false;

  *take(data) {
    this.#held = Buffer.concat([this.#held, data]);
    if (!this.#hasHead) {
      const end = this.#held.indexOf("\r\n\r\n");
      if (end < 0) return;
      this.#held = this.#held.subarray(end + 4);
      this.#hasHead = true;
    }
    for (let frame; (frame = this.#frame()); ) yield frame;
  }

  #frame() {
    const held = this.#held;
    if (held.length < 2) return undefined;
    const short = held[1];
    const head = short === 127 ? 10 : short === 126 ? 4 : 2;
    if (held.length < head) return undefined;
    const size = short === 127 ? Number(held.readBigUInt64BE(2)) : short === 126 ? held.readUInt16BE(2) : short;
    if (held.length < head + size) return undefined;
    this.#held = held.subarray(head + size);
    return [held[0] & 15, held.subarray(head, head + size)];
  }
}

/** A client of /feed that connects again whenever it is disconnected. */
export class WebSocketClient {
  frames = 0;
  #socket;
  #over = false;

  constructor(port) {
    this.port = port;
    this.#come();
  }
  leave() {
    this.#over = true;
    this.#socket.destroy();
  }
  #come() {
    if (this.#over) return;
    const splitter = new Splitter(), socket = this.#socket = connect(this.port, "127.0.0.1");
    socket.on("error", () => {});
    socket.on("close", () => setTimeout(() => this.#come(), kAgainMs));
    socket.on("data", (data) => {
      for (const [opcode, payload] of splitter.take(data)) {
        if (opcode === 9) socket.write(Buffer.concat([Buffer.from([0x8a, 0x80 | payload.length, 0, 0, 0, 0]), payload]));
        if (opcode === 2 && payload.toString("latin1", 0, 4) === "RBF1") ++this.frames;
      }
    });
    socket.write(upgrade(this.port));
  }
}

/** Whether a program still has the other end of a connection from this port: that end's line in the kernel's table, with
    the number of the file that somebody has open, 0 for nobody. */
function isHeld(port, from) {
  const hex = (number) => number.toString(16).toUpperCase().padStart(4, "0");
  const line = readFileSync("/proc/net/tcp", "latin1").split("\n").map((text) => text.trim().split(/\s+/))
    .find(([, local, remote]) => local?.endsWith(`:${hex(port)}`) && remote?.endsWith(`:${hex(from)}`));
  return line !== undefined && line[9] !== "0";
}

/** Asks for the feed and takes nothing until it is sent away; false if it is not within so long. */
export async function stall(port, ms) {
  const socket = connect(port, "127.0.0.1");
  socket.on("error", () => {});
  socket.write(upgrade(port));
  await once(socket, "connect");
  socket.pause();
  const end = performance.now() + ms;
  do await sleep(200);
  while (isHeld(port, socket.localPort) && performance.now() < end);
  const held = isHeld(port, socket.localPort);
  socket.destroy();
  return !held;
}

/** Bytes that the server took before it hung up, and the status it answered with, if that came through. */
const pour = (port, head, bytes) => new Promise((done) => {
  const socket = connect(port, "127.0.0.1");
  let sent = 0, said = "";
  const more = () => {
    while (sent < bytes) {
      sent += kUpload.length;
      if (!socket.write(kUpload)) return;
    }
    socket.end();
  };
  socket.on("error", () => {});
  socket.on("data", (data) => (said += data.toString("latin1")));
  socket.on("drain", more);
  socket.on("close", () => done({sent: sent - socket.writableLength, status: Number(said.split(" ")[1]) || undefined}));
  socket.write(head, "latin1");
  more();
});

const post = (port, path, token, length) => `POST ${path} HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\n` +
  `Origin: http://127.0.0.1:${port}\r\nContent-Type: application/json\r\nX-Roadbalance-Token: ${token}\r\n${length}\r\n\r\n`;

/** So many bytes by each way there is: a body that says how long it is, one that does not, a message on the feed. */
export const uploads = (port, token, bytes) => Promise.all([
  pour(port, post(port, "/request", token, `Content-Length: ${bytes}`), bytes),
  pour(port, post(port, "/view", token, "Transfer-Encoding: chunked") + `${bytes.toString(16)}\r\n`, bytes),
  pour(port, upgrade(port) + `\x82\xff${bytes.toString(16).padStart(16, "0").replace(/../g,
    (byte) => String.fromCharCode(parseInt(byte, 16)))}\0\0\0\0`, bytes),
]);

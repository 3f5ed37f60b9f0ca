// Makes TypeScript of the messages on the bus, from the same files as the C++:
//
//     node wire_types.mjs OUT.ts FILE...
//
// FILE.lcm gives an interface and the layout of the message, as decode.ts reads it; FILE.hpp:Name,kName gives
// enumerations and numbers of a C++ header.  A text that is not understood is an error: the page never guesses.
import {readFileSync, writeFileSync} from "node:fs";
import {fileURLToPath} from "node:url";

const kBytes = {int8_t: 1, int16_t: 2, int32_t: 4, int64_t: 8, float: 4, double: 8, byte: 1, boolean: 1};

/** "balance_t" -> "Balance" */
const camel = (name) =>
  name.replace(/_t$/, "").split("_").map((word) => word[0].toUpperCase() + word.slice(1)).join("");

/** The message of a .lcm file: {name, fields: [{name, type, extents}]}. */
export function parseLcm(text, file) {
  const lines = text.split("\n").map((line) => line.replace(/\/\/.*/, "").trim()).filter(Boolean);
  const name = /^package wire; struct (\w+) \{ (.*) \}$/.exec(lines.join(" "));
  if (!name) throw new Error(`${file}: not one struct of package wire`);
  const fields = name[2].split(";").map((field) => field.trim()).filter(Boolean).map((field) => {
    const found = /^(\w+)\s+(\w+)((?:\[\d+\])*)$/.exec(field);
    if (!found || !(found[1] in kBytes)) throw new Error(`${file}: cannot read "${field}"`);
    const extents = [...found[3].matchAll(/\d+/g)].map((extent) => Number(extent[0]));
    return {name: found[2], type: found[1], extents};
  });
  return {name: name[1], fields};
}

/** LCM's fingerprint of a message of numbers, 16 hexadecimal digits: what its first eight bytes say. */
export function fingerprint({fields}) {
  let hash = 0x12345678n;
  const add = (value) => {
    hash = BigInt.asIntN(64, (BigInt.asIntN(64, hash << 8n) ^ (hash >> 55n)) + BigInt(value));
  };
  const addText = (text) => {
    add(text.length);
    for (const letter of text) add(letter.charCodeAt(0));
  };
  for (const {name, type, extents} of fields) {
    addText(name);
    addText(type);
    add(extents.length);
    for (const extent of extents) {
      add(0);  // of constant size
      addText(String(extent));
    }
  }
  const bits = BigInt.asUintN(64, hash);
  return BigInt.asUintN(64, (bits << 1n) + (bits >> 63n)).toString(16).padStart(16, "0");
}

/** Enumerators of `enum class NAME` in a header: [[name without k, value]]. */
export function parseEnum(text, name, file) {
  const body = new RegExp(`enum class ${name}\\b[^{]*\\{([^}]*)\\}`).exec(text.replace(/\/\/.*/g, ""));
  if (!body) throw new Error(`${file}: no enum class ${name}`);
  let next = 0;
  return body[1].split(",").map((entry) => entry.trim()).filter(Boolean).map((entry) => {
    const found = /^k(\w+)(?:\s*=\s*(\d+))?$/.exec(entry);
    if (!found) throw new Error(`${file}: cannot read "${entry}" of ${name}`);
    const value = found[2] === undefined ? next : Number(found[2]);
    next = value + 1;
    return [found[1], value];
  });
}

/** Value of `inline constexpr double NAME = VALUE;` in a header. */
export function parseNumber(text, name, file) {
  const found = new RegExp(`^inline constexpr double ${name} = ([-+.\\de]+);`, "m").exec(text);
  if (!found || !Number.isFinite(Number(found[1]))) throw new Error(`${file}: no number ${name}`);
  return Number(found[1]);
}

function typeScriptOfMessage(message) {
  const size = 8 + message.fields.reduce(
    (sum, {type, extents}) => sum + extents.reduce((a, b) => a * b, kBytes[type]), 0);
  const member = ({name, extents}) => `  readonly ${name}: number${"[]".repeat(extents.length)};\n`;
  const layout = message.fields.map(({name, type, extents}) => `    ${JSON.stringify([name, type, extents])},\n`);
  return `export interface ${camel(message.name)} {\n${message.fields.map(member).join("")}}\n` +
    `export const k${camel(message.name)}: MessageType<${camel(message.name)}> = {\n` +
    `  fingerprint: "${fingerprint(message)}", bytes: ${size}, fields: [\n${layout.join("")}  ]};\n`;
}

export function typeScript(files, read) {
  let text = "// Made by wire_types.mjs.\nimport type {MessageType} from \"./decode\";\n\n";
  for (const file of files) {
    const [path, names] = file.split(":");
    if (path.endsWith(".lcm")) {
      text += typeScriptOfMessage(parseLcm(read(path), path)) + "\n";
      continue;
    }
    for (const name of (names ?? "").split(",")) {
      if (/^k[A-Z]/.test(name)) {
        text += `export const ${name} = ${parseNumber(read(path), name, path)};\n\n`;
        continue;
      }
      const entries = parseEnum(read(path), name, path).map(([key, value]) => `  ${key} = ${value},\n`);
      text += `export enum ${name} {\n${entries.join("")}}\n\n`;
    }
  }
  return text;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [out, ...files] = process.argv.slice(2);
  writeFileSync(out, typeScript(files, (path) => readFileSync(path, "utf8")));
}

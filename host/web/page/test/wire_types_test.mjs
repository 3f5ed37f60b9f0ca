// The page's reading of the bus against what lcm-gen, an independent program, makes of the same files.
import assert from "node:assert/strict";
import {readdirSync, readFileSync} from "node:fs";
import {test} from "node:test";
import {fingerprint, parseEnum, parseLcm, parseNumber, typeScript} from "../wire_types.mjs";

const {RB_SOURCE, RB_GENERATED} = process.env;

test("has lcm-gen's fingerprint of every message", () => {
  const files = readdirSync(`${RB_SOURCE}/common/wire`).filter((file) => file.endsWith(".lcm"));
  assert.ok(files.length > 10);
  for (const file of files) {
    const message = parseLcm(readFileSync(`${RB_SOURCE}/common/wire/${file}`, "utf8"), file);
    const header = readFileSync(`${RB_GENERATED}/wire/${message.name}.hpp`, "utf8");
    const base = BigInt(/uint64_t hash = (0x[0-9a-f]+)LL;/.exec(header)[1]);
    const turned = BigInt.asUintN(64, (base << 1n) + (base >> 63n));
    assert.equal(fingerprint(message), turned.toString(16).padStart(16, "0"), file);
  }
});

test("refuses what it cannot read", () => {
  const struct = (field) => `package wire;\nstruct a_t\n{\n    ${field}\n}\n`;
  assert.deepEqual(parseLcm(struct("double x[2][3]; // m"), "a").fields, [{name: "x", type: "double", extents: [2, 3]}]);
  for (const field of ["string s;", "other_t o;", "double x[n];", "const int32_t N = 5;", "int32_t a, b;"])
    assert.throws(() => parseLcm(struct(field), "a.lcm"), /a\.lcm: cannot read/, field);
  assert.throws(() => parseLcm("struct a_t { int8_t a; }", "a.lcm"), /not one struct of package wire/);
});

test("counts enumerators as C++ does", () => {
  const text = "enum class A : int {\n  kNone,  ///< 7, or\n  kFive = 5, kSix };\nenum class AB { kOne = 1 };";
  assert.deepEqual(parseEnum(text, "A", "a.hpp"), [["None", 0], ["Five", 5], ["Six", 6]]);
  assert.throws(() => parseEnum(text, "B", "a.hpp"), /no enum class B/);
  assert.throws(() => parseEnum("enum class A { kX = 1 << 2 }", "A", "a.hpp"), /cannot read/);
});

test("makes TypeScript of both", () => {
  const files = {"a.lcm": "package wire;\nstruct a_b_t\n{\n int64_t when; byte text[4];\n}", "e.hpp": "enum class E { kX = 2 };"};
  const made = typeScript(["a.lcm", "e.hpp:E"], (path) => files[path]);
  assert.match(made, /export interface AB \{\n  readonly when: number;\n  readonly text: number\[\];\n\}/);
  assert.match(made, /bytes: 20, fields: \[\n    \["when","int64_t",\[\]\],\n    \["text","byte",\[4\]\],/);
  assert.match(made, /export enum E \{\n  X = 2,\n\}/);
});

test("takes numbers of a header, and refuses what is none", () => {
  const text = "/// Of it.\ninline constexpr double kA_s = 50e-6;\ninline constexpr double kB_s = 2.0 * kA_s;\n";
  assert.equal(parseNumber(text, "kA_s", "a.hpp"), 50e-6);
  for (const name of ["kB_s", "kC_s"]) assert.throws(() => parseNumber(text, name, "a.hpp"), /a\.hpp: no number k/);
});

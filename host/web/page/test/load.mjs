// Modules of the page under node, without a browser.
import {createRequire} from "node:module";
import {join} from "node:path";

const kPackages = process.env.RB_PAGE_PACKAGES;
const {buildSync} = createRequire(join(kPackages, "package.json"))("esbuild");
globalThis.document ??= {documentElement: {dataset: {}}};
globalThis.matchMedia ??= () => ({matches: false, addEventListener() {}});
globalThis.addEventListener ??= () => {};
globalThis.devicePixelRatio ??= 1;
globalThis.navigator ??= {language: "en"};
globalThis.localStorage ??= {getItem: () => null, setItem() {}};
globalThis.sessionStorage ??= {getItem: () => null, setItem() {}};

/** All that modules of the page export, as the build has copied them, wire.ts beside them. */
export async function load(...names) {
  const made = buildSync({
    stdin: {contents: names.map((name) => `export * from "./${name}";`).join("\n"), resolveDir: join(kPackages, "src"), loader: "ts"},
    bundle: true, format: "esm", write: false, target: "node18"});
  return import(`data:text/javascript;base64,${Buffer.from(made.outputFiles[0].contents).toString("base64")}`);
}

// Makes dist/ of src/: types checked by tsc, one script by esbuild.  Run beside node_modules.
import {execFileSync} from "node:child_process";
import {copyFileSync, mkdirSync, readFileSync} from "node:fs";
import {buildSync} from "esbuild";

execFileSync(process.execPath, ["node_modules/typescript/bin/tsc", "--project", "."], {stdio: "inherit"});
mkdirSync("dist", {recursive: true});
// The licence goes with every copy.
const uplot = readFileSync("node_modules/uplot/LICENSE", "utf8");
buildSync({
  entryPoints: {page: "src/main.ts"}, outdir: "dist", bundle: true, minify: true, format: "iife",
  target: ["chrome110", "firefox115", "safari16"], logLevel: "warning",
  banner: {js: `/*! uPlot: ${uplot.trim()} */`},
});
buildSync({entryPoints: {page: "src/style.css"}, outdir: "dist", minify: true, logLevel: "warning"});
for (const file of ["index.html", "favicon.svg"]) copyFileSync(`src/${file}`, `dist/${file}`);

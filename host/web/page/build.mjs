// Makes dist/ of src/: types checked by tsc, one script by esbuild.  Run beside node_modules.
import {execFileSync} from "node:child_process";
import {copyFileSync, mkdirSync} from "node:fs";
import {buildSync} from "esbuild";

execFileSync(process.execPath, ["node_modules/typescript/bin/tsc", "--project", "."], {stdio: "inherit"});
mkdirSync("dist", {recursive: true});
buildSync({
  entryPoints: {page: "src/main.ts"}, outdir: "dist", bundle: true, minify: true, format: "iife",
  target: ["chrome110", "firefox115", "safari16"], logLevel: "warning",
});
buildSync({entryPoints: {page: "src/style.css"}, outdir: "dist", minify: true, logLevel: "warning"});
for (const file of ["index.html", "favicon.svg"]) copyFileSync(`src/${file}`, `dist/${file}`);

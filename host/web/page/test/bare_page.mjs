// A page in a browser of its own, as a passenger has it: who drives it through playwright also has the browser keep every
// request for its inspector, and scripts of playwright's own beside those of the page.
import {spawn} from "node:child_process";
import {once} from "node:events";
import {mkdtempSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {kChromium, kChromiumArguments, pictureFile} from "./browser.mjs";

export class BarePage {
  complaints = [];  // of scripts that failed
  #folder = mkdtempSync(join(tmpdir(), "rb-browser-"));
  #browser;
  #asked = new Map();
  #number = 0;
  #session;

  constructor({width, height}) {
    this.#browser = spawn(kChromium, [...kChromiumArguments, "--headless=new", "--remote-debugging-pipe", "--mute-audio",
      `--window-size=${width},${height}`, `--user-data-dir=${this.#folder}`, "about:blank"],
      {stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"]});
    let held = "";
    this.#browser.stdio[4].setEncoding("utf8").on("data", (text) => {
      const messages = (held + text).split("\0");
      held = messages.pop();
      for (const message of messages) this.#take(JSON.parse(message));
    });
    this.#browser.stdio[3].on("error", () => {});
    this.#browser.once("exit", () => {
      for (const {fail} of this.#asked.values()) fail(new Error("the browser has ended"));
      this.#asked.clear();
    });
  }
  async open(url) {
    const {targetInfos} = await this.browser("Target.getTargets");
    const {targetId} = targetInfos.find(({type}) => type === "page");
    this.#session = (await this.browser("Target.attachToTarget", {targetId, flatten: true})).sessionId;
    for (const domain of ["Page", "Performance", "Runtime"]) await this.send(`${domain}.enable`);
    await this.send("Page.navigate", {url});
  }
  async close() {
    const over = once(this.#browser, "exit");
    await this.browser("Browser.close").catch(() => this.#browser.kill("SIGKILL"));
    await over;
    rmSync(this.#folder, {recursive: true, force: true, maxRetries: 5});
  }

  /** A command of Chromium's own protocol, to the page and to the browser. */
  send(method, params = {}) {
    return this.#ask({method, params, sessionId: this.#session});
  }
  browser(method, params = {}) {
    return this.#ask({method, params});
  }
  async press(key) {
    const code = key.length > 1 ? key : undefined;  // text of a letter is itself
    const event = {key, code, text: code ? undefined : key, windowsVirtualKeyCode: key === "Escape" ? 27 : undefined};
    await this.send("Input.dispatchKeyEvent", {type: "keyDown", ...event});
    await this.send("Input.dispatchKeyEvent", {type: "keyUp", ...event});
  }
  async click(selector) {
    const [x, y] = await this.evaluate(`(() => {
      const {left, top, width, height} = document.querySelector("${selector}").getBoundingClientRect();
      return [left + width / 2, top + height / 2];
    })()`);
    for (const type of ["mousePressed", "mouseReleased"])
      await this.send("Input.dispatchMouseEvent", {type, x, y, button: "left", clickCount: 1});
  }
  async evaluate(expression) {
    const {result, exceptionDetails} = await this.send("Runtime.evaluate", {expression, returnByValue: true});
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }
  async picture(name) {
    const {data} = await this.send("Page.captureScreenshot");
    writeFileSync(pictureFile(name), data, "base64");
  }

  #ask(command) {
    const id = ++this.#number;
    return new Promise((done, fail) => {
      this.#asked.set(id, {done, fail});
      this.#browser.stdio[3].write(JSON.stringify({id, ...command}) + "\0");
    });
  }
  #take({id, result, error, method, params}) {
    if (method === "Runtime.exceptionThrown")
      this.complaints.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
    const asked = this.#asked.get(id);
    this.#asked.delete(id);
    if (error) asked?.fail(new Error(error.message));
    else asked?.done(result);
  }
}

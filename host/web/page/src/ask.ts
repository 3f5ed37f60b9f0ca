// Sends a person's requests to recorder and rb-recordings: a POST to rb-web, which repeats it on the bus until it is
// answered.  The answer comes on the feed, to every page; each page recognises its own by a unique number.
import type {Car} from "./car";
import {sessionToken} from "./feed";
import {utf8} from "./text";
import {AnswerState, Operation, type Answer} from "./wire";

/** As rb-web calls them. */
const kNames: Readonly<Record<Operation, string>> = {
  [Operation.Start]: "start", [Operation.Stop]: "stop", [Operation.Mark]: "mark", [Operation.Range]: "range",
  [Operation.Filter]: "filter", [Operation.Zero]: "zero", [Operation.Vehicle]: "vehicle",
  [Operation.Job]: "job", [Operation.Cancel]: "cancel", [Operation.Scale]: "scale",
  [Operation.Reading]: "reading", [Operation.Datum]: "datum",
};

export interface Details {
  readonly text?: string;
  readonly node?: number;
  readonly channel?: number;
  readonly value?: readonly number[];
}

export interface Asked {
  readonly request: number;
  readonly sinceMs: number;
  /** Why rb-web did not take it; empty: it did, or has not answered. */
  fault: string;
}

const kOfRecordings: readonly Operation[] = [Operation.Job, Operation.Cancel];

/** Longer than this a recorder that lives does not leave a request without any answer. */
const kPatienceMs = 5000;

/** Below 2^53, never 0. */
function randomNumber(): number {
  const [high = 0, low = 0] = crypto.getRandomValues(new Uint32Array(2));
  return (high % 0x200000) * 0x100000000 + low || 1;
}

export class Asker {
  private readonly asker = randomNumber();
  private readonly asked = new Map<Operation, Asked>();

  constructor(private readonly car: Car, private readonly changed: () => void) {}

  mayAsk(): boolean {
    return sessionToken() !== "";
  }

  /** @return its number */
  ask(operation: Operation, details: Details = {}): number {
    const asked: Asked = {request: randomNumber(), sinceMs: performance.now(), fault: ""};
    this.asked.set(operation, asked);
    const body = JSON.stringify({asker: this.asker, request: asked.request, operation: kNames[operation], ...details});
    const headers = {"Content-Type": "application/json", "X-Roadbalance-Token": sessionToken()};
    fetch("/request", {method: "POST", headers, body, redirect: "error"}).then(async (response) => {
      if (response.ok) return;
      asked.fault = response.status === 401 ? "rb-web does not accept this page's token: open the address that it prints"
        : `rb-web refuses: ${(await response.text()).trim() || response.status}`;
      this.changed();
    }).catch(() => {
      asked.fault = "rb-web cannot be reached: nothing was asked";
      this.changed();
    });
    this.changed();
    return asked.request;
  }

  /** This is what was asked last of its kind. */
  isNewest(operation: Operation, request: number): boolean {
    return this.asked.get(operation)?.request === request;
  }

  answer(operation: Operation): Answer | undefined {
    const asked = this.asked.get(operation);
    const answer = asked && this.car.answers.get(asked.request);
    return answer && answer.asker === this.asker ? answer : undefined;
  }

  /** It was asked, and the last word has not been said. */
  isUnderWay(operation: Operation, nowMs: number): boolean {
    const asked = this.asked.get(operation);
    if (!asked || asked.fault !== "") return false;
    const answer = this.answer(operation);
    return answer ? answer.state === AnswerState.UnderWay : nowMs - asked.sinceMs < kPatienceMs;
  }

  /** What has become of it, for people; empty: it was not asked. */
  says(operation: Operation, nowMs: number): {readonly text: string; readonly isBad: boolean} {
    const asked = this.asked.get(operation);
    if (!asked) return {text: "", isBad: false};
    if (asked.fault !== "") return {text: asked.fault, isBad: true};
    const answer = this.answer(operation);
    if (!answer) {
      const isLate = nowMs - asked.sinceMs >= kPatienceMs;
      const silence = kOfRecordings.includes(operation) ? "rb-recordings does not answer: is it running?"
        : "no recorder answers: is rb-recorder --recordings running?";
      return {text: isLate ? silence : "asked", isBad: isLate};
    }
    const isPartial = operation === Operation.Start && (answer.value[0] ?? 0) > 0;
    return {text: utf8(answer.text, answer.size), isBad: answer.state === AnswerState.Refused || isPartial};
  }

  /** Which of these was asked last. */
  newest(of: readonly Operation[]): Operation | undefined {
    return of.filter((operation) => this.asked.has(operation))
      .sort((a, b) => (this.asked.get(b)?.sinceMs ?? 0) - (this.asked.get(a)?.sinceMs ?? 0))[0];
  }
}

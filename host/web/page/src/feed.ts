// The one connection to rb-web.  It is reopened forever: people must see that it is gone, and need do nothing when it is
// back.

export interface FeedEvents {
  frame(frame: ArrayBuffer): void;
  connected(is: boolean): void;
}

const kRetryMs = 1000;
const kLongestFrameBytes = 1 << 20;

/** The session's token stands behind the # of the address, where browsers keep it to themselves; it is taken out of
    sight, and kept as long as the tab. */
export function sessionToken(): string {
  const found = /token=([\w-]+)/.exec(location.hash)?.[1];
  if (found) {
    sessionStorage.setItem("token", found);
    history.replaceState(null, "", location.pathname);
  }
  return found ?? sessionStorage.getItem("token") ?? "";
}

/** @param viewer  what this page calls itself in what it asks (view_t) */
export function connectFeed(viewer: number, events: FeedEvents): void {
  const open = () => {
    const token = sessionToken();  // a person may have put it into the address since the last try
    const protocols = ["roadbalance", `viewer.${viewer}`, ...(token ? [`token.${token}`] : [])];
    const socket = new WebSocket(`ws://${location.host}/feed`, protocols);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => events.connected(true);
    socket.onmessage = ({data}: MessageEvent<ArrayBuffer | string>) => {
      if (data instanceof ArrayBuffer && data.byteLength <= kLongestFrameBytes) events.frame(data);
    };
    socket.onclose = () => {
      events.connected(false);
      setTimeout(open, kRetryMs);
    };
  };
  open();
}

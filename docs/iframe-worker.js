// A hyphen before a word excludes it from a search, but options begin with two: leave them out.
function plain(message) {
  const { data } = message;
  return typeof data === "string" ? { ...message, data: data.replace(/(^|\s)-+/g, "$1") } : message;
}

class PlainWorker extends Worker {
  postMessage(message) {
    super.postMessage(plain(message));
  }
}

// A page opened from a file may start no worker, on which the search runs. This class has the
// same interface and runs the script in a hidden frame. Served pages use the real one.
class FrameWorker extends EventTarget {
  constructor(url) {
    super();
    const frame = document.createElement("iframe");
    frame.hidden = true;
    document.body.append(frame);
    this.inner = frame.contentWindow;
    this.inner.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
    this.inner.importScripts = (...urls) => urls.reduce((done, next) => done.then(() => this.load(next)), Promise.resolve());
    this.ready = this.load(url);
  }

  load(url) {
    return new Promise((resolve) => {
      const script = this.inner.document.createElement("script");
      script.src = url;
      script.onload = resolve;
      this.inner.document.body.append(script);
    });
  }

  postMessage(message) {
    const data = structuredClone(plain(message));
    this.ready.then(() => this.inner.dispatchEvent(new MessageEvent("message", { data })));
  }
}

window.Worker = location.protocol === "file:" ? FrameWorker : PlainWorker;

// The search of the site runs in a worker, which browsers refuse to pages that are opened as files. There a hidden frame
// takes its place: the same script, the same messages. Material's search knows it by its name.
class IFrameWorker extends EventTarget {
  constructor(url) {
    super();
    this.frame = document.createElement("iframe");
    this.frame.hidden = true;
    document.body.appendChild(this.frame);
    const inside = this.frame.contentWindow;
    inside.document.open();
    inside.document.write(
      `<html><body><script>
        postMessage = data => frameElement.worker.dispatchEvent(new parent.MessageEvent("message", { data }));
        importScripts = (...urls) => urls.reduce((before, url) => before.then(() => new Promise((done, failed) => {
          const script = document.createElement("script");
          script.src = url; script.onload = done; script.onerror = failed;
          document.body.appendChild(script);
        })), Promise.resolve());
      <\/script><script src="${url}"><\/script></body></html>`
    );
    this.frame.worker = this;
    this.ready = new Promise(done => { this.frame.onload = done; });
    inside.document.close();
    this.addEventListener("message", event => this.onmessage?.(event));
  }

  postMessage(data) {
    this.ready.then(() => {
      const inside = this.frame.contentWindow;
      inside.dispatchEvent(new inside.MessageEvent("message", { data }));
    });
  }

  terminate() { this.frame.remove(); }
}

if (location.protocol === "file:") {
  window.IFrameWorker = IFrameWorker;
  window.Worker = IFrameWorker;
}

// The site's search runs in a worker, which browsers refuse to a page from the disk: there, an iframe takes its part.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(script) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      const inside = frame.contentWindow;
      inside.document.open();
      inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
      this.inside = new Promise((ready) => {
        const element = inside.document.createElement("script");
        element.onload = () => ready(inside);
        element.src = script;
        inside.document.write("<body></body>");
        inside.document.body.append(element);
        inside.document.close();
      });
    }

    async postMessage(data) {
      const inside = await this.inside;
      inside.dispatchEvent(new MessageEvent("message", { data: structuredClone(data) }));
    }
  };
}
